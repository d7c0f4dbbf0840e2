#pragma once
// A file that several ranks write at their own places, and what makes it last.
//
// Plain POSIX writes: an error of the disk comes back as a message at once, from the rank that saw it. (A
// collective write through MPI-IO that fails on one rank may hang or end the job in the library.)
// Nothing here communicates: callers agree on the message of the first rank that failed.

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <new>
#include <span>
#include <string>
#include <string_view>

namespace moraine {

class DiskFile {
  public:
    enum class Mode { create, append };  ///< create: also empties what is there

    /// Throws MachineError, as all members do.
    DiskFile(const std::string& path, Mode mode);
    ~DiskFile();
    DiskFile(const DiskFile&) = delete;
    DiskFile& operator=(const DiskFile&) = delete;

    void write(std::span<const std::byte> bytes, std::int64_t at);
    void sync();

  private:
    [[noreturn]] void fail(const char* verb) const;

    std::string path_;
    int handle_ = -1;
};

/// `from` becomes `to` in one moment, also after a loss of power. Throws MachineError.
void move_file(const std::string& from, const std::string& to);

/// `text` becomes the content of `path` in one moment. Throws MachineError.
void replace_file(const std::string& path, std::string_view text);

/// The same of a text that is made piece by piece: make(write) calls write(piece) for each.
void replace_file_by(const std::string& path,
                     const std::function<void(const std::function<void(std::string_view)>&)>& make);

/// What `action` throws, as a message; empty if it does not. For Comm::agree_no_error.
template <class Action>
std::string message_of(Action&& action) {
    try {
        action();
    } catch (const std::bad_alloc&) {
        return "memory ran out. More ranks, or a larger domain.cell?";
    } catch (const std::exception& error) {
        return error.what();
    }
    return {};
}

}  // namespace moraine
