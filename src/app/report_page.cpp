#include "app/report_page.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

namespace moraine {

bool is_script(const char* command) {
    for (const char* script : {"report", "picture", "converge"})
        if (std::strcmp(command, script) == 0) return true;
    return false;
}

int become_script(int argc, char** argv) {
    constexpr int machine_failed = 4;
    std::error_code failed;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", failed);
    const bool report = std::strcmp(argv[1], "report") == 0;  // the others are commands of the Python package
    const std::string script = (program.parent_path() / (report ? "report" : "package")).string();
    if (failed || !std::filesystem::exists(script + "/__main__.py")) {
        fmt::print(stderr, "moraine: the script of moraine {} is not beside the program (no {}). Build it again?\n",
                   argv[1], script);
        return machine_failed;
    }
    const char* chosen = std::getenv("MORAINE_PYTHON");
    std::string python = chosen && *chosen ? chosen : "python3";
    std::vector<std::string> words{python, "-B", script};
    for (int k = report ? 2 : 1; k < argc; ++k) words.emplace_back(argv[k]);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::execvp(arguments[0], arguments.data());
    fmt::print(stderr, "moraine: cannot start {} ({}). Install python3, python3-matplotlib and python3-h5py?\n", python,
               std::strerror(errno));
    return machine_failed;
}

}  // namespace moraine
