#include "io/checkpoint_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "io/checkpoint.hpp"
#include "io/disk_file.hpp"

namespace moraine {

std::string checkpoint_name(std::int64_t step) {
    return fmt::format("checkpoint-{:09}.h5", step);
}

namespace checkpoint {

namespace {

constexpr std::uint64_t magic = 0x314c414553524f4dULL;  // "MORSEAL1"

/// 64-bit FNV-1a: each step is a bijection, so one changed byte always changes the result.
class Fnv {
  public:
    void add(const char* data, std::size_t bytes) {
        for (std::size_t i = 0; i < bytes; ++i) {
            hash_ ^= static_cast<unsigned char>(data[i]);
            hash_ *= 0x100000001b3ULL;
        }
    }
    std::uint64_t value() const { return hash_; }

  private:
    std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

/// Hash of the first `end` bytes of the file, without the regions of rows (ascending).
std::uint64_t hash_of_rest(const std::string& path, const std::vector<Region>& rows, std::int64_t end) {
    std::ifstream file(path, std::ios::binary);
    Fnv hash;
    std::vector<char> buffer(1 << 20);
    const auto add = [&](std::int64_t from, std::int64_t to) {
        file.seekg(from);
        while (from < to) {
            const auto bytes = std::min<std::int64_t>(static_cast<std::int64_t>(buffer.size()), to - from);
            if (!file.read(buffer.data(), bytes)) throw std::runtime_error("it cannot be read");
            hash.add(buffer.data(), static_cast<std::size_t>(bytes));
            from += bytes;
        }
    };
    std::int64_t at = 0;
    for (const Region& region : rows) {
        add(at, region.at);
        at = region.at + region.bytes;
    }
    add(at, end);
    return hash.value();
}

std::uint64_t hash_of(const std::vector<std::uint64_t>& words, std::size_t count) {
    Fnv hash;
    hash.add(reinterpret_cast<const char*>(words.data()), count * sizeof words[0]);
    return hash.value();
}

/// The last `count` words of a file of `size` bytes.
std::vector<std::uint64_t> last_words(const std::string& path, std::int64_t size, std::int64_t count) {
    std::vector<std::uint64_t> words(static_cast<std::size_t>(count));
    std::ifstream file(path, std::ios::binary);
    file.seekg(size - 8 * count);
    if (!file.read(reinterpret_cast<char*>(words.data()), 8 * count)) throw std::runtime_error("it cannot be read");
    return words;
}

}  // namespace

// Words of the seal: where each region begins and its bytes, hash of the rest, hash of the words before,
// number of words in all, magic.
void seal(const std::string& path, std::vector<Region> rows) {
    std::sort(rows.begin(), rows.end(), [](const Region& a, const Region& b) { return a.at < b.at; });
    const auto end = static_cast<std::int64_t>(std::filesystem::file_size(path));
    std::vector<std::uint64_t> words;
    for (const Region& region : rows)
        words.insert(words.end(), {static_cast<std::uint64_t>(region.at), static_cast<std::uint64_t>(region.bytes)});
    words.push_back(hash_of_rest(path, rows, end));
    words.push_back(hash_of(words, words.size()));
    words.insert(words.end(), {words.size() + 2, magic});
    DiskFile(path, DiskFile::Mode::append).write(std::as_bytes(std::span(words)), end);
}

void check_seal(const std::string& path) {
    std::error_code unknown;
    if (!std::filesystem::is_regular_file(path, unknown))
        throw std::runtime_error(unknown && unknown != std::errc::no_such_file_or_directory ? unknown.message()
                                                                                            : "there is no such file");
    const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
    constexpr const char* damaged = "it is truncated or damaged, or no checkpoint of this program";
    if (size < 32) throw std::runtime_error(damaged);
    const auto foot = last_words(path, size, 2);
    if (foot[1] != magic || foot[0] < 4 || foot[0] % 2 != 0 || foot[0] > static_cast<std::uint64_t>(size) / 8)
        throw std::runtime_error(damaged);
    const auto words = last_words(path, size, static_cast<std::int64_t>(foot[0]));
    const std::size_t hashes = words.size() - 4;
    if (words[hashes + 1] != hash_of(words, hashes + 1)) throw std::runtime_error(damaged);
    std::vector<Region> rows;
    for (std::size_t w = 0; w < hashes; w += 2)
        rows.push_back({static_cast<std::int64_t>(words[w]), static_cast<std::int64_t>(words[w + 1])});
    const auto end = size - static_cast<std::int64_t>(8 * words.size());
    if (words[hashes] != hash_of_rest(path, rows, end)) throw std::runtime_error("bits of it have changed");
}

hid_t file_type(Column::Type type) {
    switch (type) {
        case Column::Type::u8:
            return H5T_STD_U8LE;
        case Column::Type::u16:
            return H5T_STD_U16LE;
        case Column::Type::u32:
            return H5T_STD_U32LE;
        case Column::Type::u64:
            return H5T_STD_U64LE;
        case Column::Type::f32:
            return H5T_IEEE_F32LE;
        default:
            return H5T_IEEE_F64LE;
    }
}

}  // namespace checkpoint

}  // namespace moraine
