#include "app/run_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "core/data/error.hpp"

namespace moraine {
namespace {

std::string lock_file(const std::string& directory) {
    return directory + "/run.lock";
}

std::string host_name() {
    std::array<char, 256> name{};
    ::gethostname(name.data(), name.size() - 1);
    return name.data();
}

struct Holder {
    std::string host = "?";
    long process = 0;
};

Holder holder_of(const std::string& path) {
    Holder holder;
    std::ifstream(path) >> holder.host >> holder.process;
    return holder;
}

[[noreturn]] void refuse_held(const std::string& path) {
    const Holder holder = holder_of(path);
    throw InputError(fmt::format("another run writes into {} (process {} on {}). Wait for it, or another --output?",
                                 path.substr(0, path.rfind('/')), holder.process, holder.host));
}

bool lives_here(const Holder& holder) {
    return holder.host == host_name() && holder.process > 0 && holder.process != ::getpid() &&
           (::kill(static_cast<pid_t>(holder.process), 0) == 0 || errno == EPERM);
}

/// Takes flock, or throws InputError if it is held.
void take(int handle, const std::string& path) {
    if (::flock(handle, LOCK_EX | LOCK_NB) == 0) return;
    if (errno == EWOULDBLOCK || lives_here(holder_of(path))) refuse_held(path);
}

/// False if the holder before removed the file between our opening and locking it: the lock is of no file then.
bool is_still(int handle, const std::string& path) {
    struct stat mine {};
    struct stat there {};
    return ::fstat(handle, &mine) == 0 && ::stat(path.c_str(), &there) == 0 && mine.st_ino == there.st_ino &&
           mine.st_dev == there.st_dev;
}

}  // namespace

RunLock::RunLock(const std::string& directory) : path_(lock_file(directory)) {
    for (;;) {
        handle_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (handle_ < 0)
            throw InputError(
                fmt::format("cannot write into {} ({}). Another --output?", directory, std::strerror(errno)));
        try {
            take(handle_, path_);
        } catch (...) {
            ::close(handle_);
            throw;
        }
        if (is_still(handle_, path_)) break;
        ::close(handle_);
    }
    const std::string words = fmt::format("{} {}\n", host_name(), ::getpid());
    // Words only: a full disk is told by what is written next.
    if (::ftruncate(handle_, 0) != 0 || ::pwrite(handle_, words.data(), words.size(), 0) < 0) errno = 0;
}

RunLock::~RunLock() {
    if (handle_ < 0) return;
    ::unlink(path_.c_str());
    ::close(handle_);
}

RunLock::RunLock(RunLock&& other) noexcept : path_(std::move(other.path_)), handle_(std::exchange(other.handle_, -1)) {}

RunLock& RunLock::operator=(RunLock&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(handle_, other.handle_);
    return *this;
}

void RunLock::check_free(const std::string& directory) {
    const std::string path = lock_file(directory);
    const int handle = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (handle < 0) return;  // none there
    try {
        take(handle, path);
    } catch (...) {
        ::close(handle);
        throw;
    }
    ::close(handle);
}

}  // namespace moraine
