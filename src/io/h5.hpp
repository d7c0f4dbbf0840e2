#pragma once
// HDF5 handles that close themselves, and calls that throw instead of printing.
//
// H5Quiet silences the library, from then on: damaged files are expected here, and the words for them are ours. At
// the end of the program it would still complain of what it could not close.

#include <hdf5.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace moraine {

/// What went wrong inside a file; callers turn it into an InputError or MachineError with its path.
struct H5Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class H5Id {
  public:
    using Close = herr_t (*)(hid_t);

    H5Id() = default;
    /// Throws H5Failure(`what`) if `id` is none.
    H5Id(hid_t id, Close closer, const std::string& what) : id_(id), close_(closer) {
        if (id < 0) throw H5Failure(what);
    }
    ~H5Id() {
        if (id_ >= 0) close_(id_);
    }
    H5Id(H5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    H5Id& operator=(H5Id&& other) noexcept {
        std::swap(id_, other.id_);
        std::swap(close_, other.close_);
        return *this;
    }
    operator hid_t() const { return id_; }

    /// Close now, and throw H5Failure(`what`) if that fails (the last bytes are written then).
    void close(const std::string& what) {
        if (id_ >= 0 && close_(std::exchange(id_, -1)) < 0) throw H5Failure(what);
    }

  private:
    hid_t id_ = -1;
    Close close_ = nullptr;
};

inline void h5_check(herr_t status, const std::string& what) {
    if (status < 0) throw H5Failure(what);
}

struct H5Quiet {
    H5Quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }
};

}  // namespace moraine
