#include "compile/system_compiler.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/data/error.hpp"
#include "core/data/processor.hpp"

extern char** environ;

namespace moraine {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t longest_message = 1500;  // bytes

std::vector<std::string> split(const std::string& text) {
    std::istringstream in(text);
    return {std::istream_iterator<std::string>(in), {}};
}

/// Where the shell would find it; empty: nowhere.
fs::path find_program(const std::string& name) {
    if (name.find('/') != std::string::npos) return access(name.c_str(), X_OK) == 0 ? fs::path(name) : fs::path();
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (const fs::path found = fs::path(folder) / name; access(found.c_str(), X_OK) == 0) return found;
    return {};
}

std::string content_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A folder of its own, away again afterwards.
class Folder {
  public:
    Folder() {
        std::error_code failed;
        std::string name = (fs::temp_directory_path(failed) / "moraine-XXXXXX").string();
        if (failed || !mkdtemp(name.data()))
            throw InputError("cannot be compiled (no temporary folder can be made). Does TMPDIR name a place for it?");
        path_ = name;
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    fs::path operator/(const std::string& name) const { return path_ / name; }
    const fs::path& path() const { return path_; }

    void write(const std::string& name, const std::string& text) const {
        const fs::path file = path_ / name;
        fs::create_directories(file.parent_path());
        std::ofstream out(file, std::ios::binary);
        out << text;
        out.close();
        if (!out) throw InputError("cannot be compiled (the temporary folder is full). Does TMPDIR name another one?");
    }

  private:
    fs::path path_;
};

/// Its exit code, or -1. What it says goes to a file.
int run(std::vector<std::string> words, const fs::path& log) {
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&files, 1, 2);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t child = 0;
    const int failed = posix_spawn(&child, arguments[0], &files, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (failed) return -1;
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// The first lines, without the name of the temporary folder.
std::string first_lines(std::string log, const std::string& folder) {
    for (std::size_t at = log.find(folder); at != std::string::npos; at = log.find(folder, at))
        log.erase(at, folder.size());
    if (log.size() > longest_message) log = log.substr(0, log.rfind('\n', longest_message)) + "\n...";
    while (!log.empty() && log.back() == '\n') log.pop_back();
    return log;
}

}  // namespace

SystemCompiler::SystemCompiler() {
    const char* named = std::getenv("CXX");
    command_ = split(named ? named : "");
    if (command_.empty()) command_ = {"c++"};
    const fs::path found = find_program(command_[0]);
    if (found.empty())
        throw InputError("cannot be compiled (there is no " + command_[0] + "). Install g++, or name one by CXX?");
    std::error_code failed;
    const fs::path real = fs::canonical(found, failed);
    command_[0] = found.string();
    for (const std::string& word : command_) identity_ += word + ' ';
    identity_ += real.string() + ' ' + std::to_string(fs::file_size(real, failed)) + ' ' +
                 std::to_string(fs::last_write_time(real, failed).time_since_epoch().count());
}

std::vector<std::string> SystemCompiler::options() {
    std::vector<std::string> words = split(MORAINE_LAW_OPTIONS);
    for (const std::string& word : split(uses_avx512() ? MORAINE_LAW_AVX512_OPTIONS : "")) words.push_back(word);
    return words;
}

std::string SystemCompiler::compile(const std::string& text, const SourceBundle& headers) const {
    const Folder folder;
    for (const SourceFile& header : headers.files) folder.write(header.name, header.text);
    folder.write("law.cpp", text);
    std::vector<std::string> words = command_;
    for (const std::string& option : options()) words.push_back(option);
    for (const std::string& word : {"-I" + folder.path().string(), std::string("-o"), (folder / "law.so").string(),
                                    (folder / "law.cpp").string()})
        words.push_back(word);
    const fs::path log = folder / "log";
    if (run(words, log) != 0)
        throw CompilerError("does not compile (by " + command_[0] + "). Mend what it says?\n" +
                            first_lines(content_of(log), folder.path().string() + "/"));
    return content_of(folder / "law.so");
}

}  // namespace moraine
