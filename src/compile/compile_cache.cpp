#include "compile/compile_cache.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

#include "core/data/hash.hpp"

namespace moraine {

namespace fs = std::filesystem;

namespace {

constexpr const char* ending = ".kernels";
constexpr const char* magic = "moraine kernels 1";

std::uint64_t hash_of(const std::string& text, std::uint64_t seed) {
    return mix_bytes(seed + text.size(), reinterpret_cast<const std::byte*>(text.data()), text.size());
}

/// Held while it lives; no lock where the file system gives none.
class RecordLock {
  public:
    RecordLock(const fs::path& file, const std::string& key) {
        descriptor_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
        if (descriptor_ < 0) return;
        struct flock wanted {};
        wanted.l_type = F_WRLCK;
        wanted.l_whence = SEEK_SET;
        wanted.l_start = static_cast<off_t>(hash_of(key, 0) >> 2);
        wanted.l_len = 1;
        while (fcntl(descriptor_, F_OFD_SETLKW, &wanted) < 0 && errno == EINTR) {
        }
    }
    RecordLock(const RecordLock&) = delete;
    RecordLock& operator=(const RecordLock&) = delete;
    ~RecordLock() {
        if (descriptor_ >= 0) close(descriptor_);
    }

  private:
    int descriptor_;
};

}  // namespace

std::string hexadecimal(std::uint64_t value) {
    char digits[17];
    std::snprintf(digits, sizeof(digits), "%016llx", static_cast<unsigned long long>(value));
    return digits;
}

CompileCache::CompileCache(fs::path folder, std::vector<fs::path> besides)
    : folder_(std::move(folder)), besides_(std::move(besides)) {}

std::string CompileCache::key(const std::string& text, const std::vector<std::string>& options,
                              const std::string& compiler, std::uint64_t sources) {
    std::string all = compiler + '\n' + hexadecimal(sources) + '\n';
    for (const std::string& option : options) all += option + '\n';
    all += text;
    return hexadecimal(hash_of(all, 0x6d6f7261696e65)) + hexadecimal(hash_of(all, 0x6b65726e656c73));
}

std::optional<std::string> CompileCache::find(const std::string& key) const {
    const auto look = [&](const fs::path& folder) -> std::optional<std::string> {
        const fs::path path = folder / (key + ending);
        std::ifstream in(path, std::ios::binary);
        std::string first, hash;
        if (!std::getline(in, first) || first != magic || !std::getline(in, hash)) return {};
        std::string body((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
        if (hash != hexadecimal(hash_of(body, 1))) return {};
        return body;
    };
    if (!folder_.empty())
        if (auto found = look(folder_)) {
            std::error_code ignored;  // when it was used last
            fs::last_write_time(folder_ / (key + ending), fs::file_time_type::clock::now(), ignored);
            return found;
        }
    for (const fs::path& folder : besides_)
        if (auto found = look(folder)) return found;
    return {};
}

std::string CompileCache::find_or_make(const std::string& key, const std::function<std::string()>& make) const {
    if (auto found = find(key)) return std::move(*found);
    if (folder_.empty()) return make();
    std::error_code cannot;
    fs::create_directories(folder_, cannot);
    if (cannot) return make();
    const RecordLock lock(folder_ / "lock", key);
    if (auto found = find(key)) return std::move(*found);
    std::string made = make();
    keep(key, made);
    drop_oldest();
    return made;
}

void CompileCache::keep(const std::string& key, const std::string& content) const {
    const fs::path path = folder_ / (key + ending);
    const fs::path partial = folder_ / (key + "." + std::to_string(getpid()) + ".partial");
    std::error_code ignored;
    {
        std::ofstream out(partial, std::ios::binary);
        out << magic << '\n' << hexadecimal(hash_of(content, 1)) << '\n' << content;
        out.close();
        if (!out) {
            fs::remove(partial, ignored);
            return;
        }
    }
    fs::rename(partial, path, ignored);
    if (ignored) fs::remove(partial, ignored);
}

void CompileCache::drop_oldest() const {
    struct File {
        fs::path path;
        fs::file_time_type used;
        std::uintmax_t bytes;
    };
    std::vector<File> files;
    std::uintmax_t sum = 0;
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored)) {
        if (entry.path().extension() != ending) continue;
        files.push_back({entry.path(), entry.last_write_time(ignored), entry.file_size(ignored)});
        sum += files.back().bytes;
    }
    std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used < b.used; });
    for (std::size_t k = 0; k < files.size() && sum > most; ++k) {
        fs::remove(files[k].path, ignored);
        sum -= files[k].bytes;
    }
}

fs::path kernel_cache_folder(const std::string& wanted) {
    if (wanted == "none") return {};
    if (!wanted.empty()) return wanted;
    const auto variable = [](const char* name) -> std::string {
        const char* value = std::getenv(name);
        return value ? value : "";
    };
    if (const std::string named = variable("MORAINE_KERNEL_CACHE"); !named.empty())
        return named == "none" ? fs::path() : fs::path(named);
    if (const std::string cache = variable("XDG_CACHE_HOME"); !cache.empty())
        return fs::path(cache) / "moraine/kernels";
    if (const std::string home = variable("HOME"); !home.empty()) return fs::path(home) / ".cache/moraine/kernels";
    return {};
}

}  // namespace moraine
