#pragma once
// Compiled programs on disk, one file each, so that a scene's kernels are compiled once per machine and not once per
// run. The name of a file is a hash of all that the image follows from: text, sources, options, compiler.
//
// A file appears by rename and holds a hash of its content: one that is cut off or damaged counts as absent. Writers of
// one program wait for each other (a record lock per key in the file `lock`); where a file system knows no locks, both
// compile the same. Beyond `most` bytes those go that were used longest ago.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gpu/compile/program.hpp"

namespace moraine::gpu {

class KernelCache {
  public:
    static constexpr std::uintmax_t most = std::uintmax_t(512) << 20;  ///< bytes

    /// folder: empty: nothing is kept. besides: folders that are read and not written.
    explicit KernelCache(std::filesystem::path folder = {}, std::vector<std::filesystem::path> besides = {});

    const std::filesystem::path& folder() const { return folder_; }

    /// Hash of what a program's image follows from, 32 hexadecimal digits.
    static std::string key(const std::string& text, const std::vector<std::string>& options,
                           const std::string& compiler);

    std::optional<CompiledProgram> find(const std::string& key) const;
    /// The program of this key; make() is called where it is not there, while others wait. Not being able to write is
    /// no error.
    CompiledProgram find_or_make(const std::string& key, const std::function<CompiledProgram()>& make) const;

  private:
    void keep(const std::string& key, const CompiledProgram& program) const;
    void drop_oldest() const;

    std::filesystem::path folder_;
    std::vector<std::filesystem::path> besides_;
};

/// What --kernel-cache names: that folder, nothing for `none`, else MORAINE_KERNEL_CACHE, else `moraine/kernels` in the
/// user's cache folder (XDG_CACHE_HOME, ~/.cache).
std::filesystem::path kernel_cache_folder(const std::string& wanted);

}  // namespace moraine::gpu
