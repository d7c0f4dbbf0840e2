#pragma once
// A folder for the files of one test case, gone with it.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "comm/comm.hpp"

class TestFolder {
  public:
    /// Collective.
    explicit TestFolder(const moraine::Comm& comm) : comm_(comm) {
        const auto name = "moraine-test-" + std::to_string(::getpid());
        path_ = comm.broadcast((std::filesystem::temp_directory_path() / name).string());
        if (comm.is_root()) std::filesystem::create_directories(path_);
        comm.barrier();
    }
    ~TestFolder() {
        comm_.barrier();
        if (comm_.is_root()) std::filesystem::remove_all(path_);
    }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;

    std::string operator/(const std::string& name) const { return path_ + "/" + name; }
    const std::string& path() const { return path_; }

  private:
    const moraine::Comm& comm_;
    std::string path_;
};

inline std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline void set_content(const std::string& path, const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
}
