#include "io/disk_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "core/data/error.hpp"

namespace moraine {

namespace {

void sync_folder_of(const std::string& path) {
    const auto folder = std::filesystem::path(path).parent_path();
    const int handle = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (handle < 0) return;  // a file system that does not let folders be opened needs no sync of them
    ::fsync(handle);
    ::close(handle);
}

/// What may help against an error of the system.
const char* remedy(int error) {
    if (error == EFBIG) return "Raise the limit on the size of files (ulimit -f)?";
    if (error == ENOENT) return "Is the directory gone, or on a disk that not all hosts share?";
    return "Is the disk full or read-only?";
}

}  // namespace

DiskFile::DiskFile(const std::string& path, Mode mode) : path_(path) {
    // Nobody but a run makes partial files: a link of that name would have it write into any file.
    const bool partial = path.ends_with(".partial");
    if (partial && mode == Mode::create) ::unlink(path.c_str());
    const int flags = (mode == Mode::create ? O_CREAT | O_TRUNC : 0) | (partial ? O_NOFOLLOW : 0);
    handle_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666);
    if (handle_ < 0) fail("open");
}

DiskFile::~DiskFile() {
    if (handle_ >= 0) ::close(handle_);
}

void DiskFile::fail(const char* verb) const {
    throw MachineError(fmt::format("cannot {} {} ({}). {}", verb, path_, std::strerror(errno), remedy(errno)));
}

void DiskFile::write(std::span<const std::byte> bytes, std::int64_t at) {
    while (!bytes.empty()) {
        const ssize_t done = ::pwrite(handle_, bytes.data(), bytes.size(), at);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) fail("write");
        bytes = bytes.subspan(static_cast<std::size_t>(done));
        at += done;
    }
}

void DiskFile::sync() {
    if (::fsync(handle_) != 0) fail("write");
}

void move_file(const std::string& from, const std::string& to) {
    if (std::rename(from.c_str(), to.c_str()) != 0)
        throw MachineError(fmt::format("cannot write {} ({}). {}", to, std::strerror(errno), remedy(errno)));
    sync_folder_of(to);
}

void replace_file(const std::string& path, std::string_view text) {
    replace_file_by(path, [&](const auto& write) { write(text); });
}

void replace_file_by(const std::string& path,
                     const std::function<void(const std::function<void(std::string_view)>&)>& make) {
    const std::string partial = path + ".partial";
    {
        DiskFile file(partial, DiskFile::Mode::create);
        std::int64_t at = 0;
        make([&](std::string_view piece) {
            file.write(std::as_bytes(std::span(piece)), at);
            at += static_cast<std::int64_t>(piece.size());
        });
        file.sync();
    }
    move_file(partial, path);
}

}  // namespace moraine
