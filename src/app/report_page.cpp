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
namespace {

/// Beside the program, as it is built, or in the share folder of where it is installed; empty: in neither.
std::filesystem::path script_folder(const std::filesystem::path& program, const std::string& name) {
    const std::filesystem::path here = program.parent_path();
    for (const auto& place : {here, here.parent_path() / "share/moraine"})
        if (std::filesystem::exists(place / name / "__main__.py")) return place / name;
    return {};
}

}  // namespace

bool is_script(const char* command) {
    for (const char* script : {"report", "picture", "converge", "study", "calibrate", "stability"})
        if (std::strcmp(command, script) == 0) return true;
    return false;
}

int become_script(int argc, char** argv) {
    constexpr int machine_failed = 4;
    std::error_code failed;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", failed);
    const bool report = std::strcmp(argv[1], "report") == 0;  // the others are commands of the Python package
    const std::string script = script_folder(program, report ? "report" : "package").string();
    if (failed || script.empty()) {
        fmt::print(
            stderr,
            "moraine: the script of moraine {} is neither beside {} nor in ../share/moraine (it was moved, or not "
            "all of it installed). Build or install it again?\n",
            argv[1], program.string());
        return machine_failed;
    }
    ::setenv("MORAINE_PROGRAM", program.c_str(), 0);  // which the scripts start
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
