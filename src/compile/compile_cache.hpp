#pragma once
// What runs compile, on disk, one file each: device kernels and laws of the user's own are compiled once per machine
// and not once per run. The name of a file is a hash of all that its content follows from: text, sources, options,
// compiler.
//
// A file appears by rename and holds a hash of its content: one that is cut off or damaged counts as absent. Writers of
// one key wait for each other (a record lock per key in the file `lock`); where a file system knows no locks, both
// compile the same. Beyond `most` bytes those go that were used longest ago.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace moraine {

class CompileCache {
  public:
    static constexpr std::uintmax_t most = std::uintmax_t(512) << 20;  ///< bytes

    /// folder: empty: nothing is kept. besides: folders that are read and not written.
    explicit CompileCache(std::filesystem::path folder = {}, std::vector<std::filesystem::path> besides = {});

    const std::filesystem::path& folder() const { return folder_; }

    /// Hash of what is compiled: sources (its headers), options, compiler and text; 32 hexadecimal digits.
    static std::string key(const std::string& text, const std::vector<std::string>& options,
                           const std::string& compiler, std::uint64_t sources);

    std::optional<std::string> find(const std::string& key) const;
    /// The content of this key; make() is called where it is not there, while others wait. Not being able to write is
    /// no error.
    std::string find_or_make(const std::string& key, const std::function<std::string()>& make) const;

  private:
    void keep(const std::string& key, const std::string& content) const;
    void drop_oldest() const;

    std::filesystem::path folder_;
    std::vector<std::filesystem::path> besides_;
};

/// What --kernel-cache names: that folder, nothing for `none`, else MORAINE_KERNEL_CACHE, else `moraine/kernels` in the
/// user's cache folder (XDG_CACHE_HOME, ~/.cache).
std::filesystem::path kernel_cache_folder(const std::string& wanted);

/// 16 digits.
std::string hexadecimal(std::uint64_t value);

}  // namespace moraine
