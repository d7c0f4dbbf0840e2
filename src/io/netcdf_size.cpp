#include "io/netcdf_size.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "io/input_error.hpp"

namespace moraine {
namespace {

[[noreturn]] void refuse_short(const std::string& path, const std::string& why) {
    refuse(path, "the netCDF file is cut short", why, "Is the copy complete?");
}

/// The header, number by number (big endian).
class Header {
  public:
    Header(std::ifstream& file, const std::string& path, int version)
        : file_(file), path_(path), size_(std::filesystem::file_size(path)), version_(version) {}

    std::uint64_t word(int bytes) {
        std::uint64_t value = 0;
        for (int k = 0; k < bytes; ++k) {
            const int byte = file_.get();
            if (byte < 0) refuse_short(path_, "its header has no end");
            value = value << 8 | static_cast<std::uint64_t>(byte);
        }
        return value;
    }
    std::uint64_t tag() { return word(4); }
    std::uint64_t count() { return word(version_ == 5 ? 8 : 4); }  ///< of elements
    std::uint64_t place() { return word(version_ == 1 ? 4 : 8); }
    /// Of a list: its tag and length; an absent one is two zeros.
    std::uint64_t list() {
        tag();
        const std::uint64_t n = count();
        if (n > size_) refuse_short(path_, fmt::format("its header has a list of {}", n));
        return n;
    }
    void skip(std::uint64_t bytes) {
        const std::uint64_t padded = (bytes + 3) / 4 * 4;
        if (padded > size_) refuse_short(path_, "its header has no end");
        file_.seekg(static_cast<std::streamoff>(padded), std::ios::cur);
    }
    void name() { skip(count()); }
    void attributes() {
        for (std::uint64_t n = list(); n > 0; --n) {
            name();
            const std::uint64_t bytes = bytes_of(tag()), values = count();
            if (values > size_) refuse_short(path_, "its header has no end");
            skip(bytes * values);
        }
    }
    std::uint64_t bytes_of(std::uint64_t type) const {
        static constexpr std::uint64_t bytes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
        if (type == 0 || type > 11) refuse_short(path_, fmt::format("its header has a type {}", type));
        return bytes[type];
    }
    std::uint64_t size() const { return size_; }

  private:
    std::ifstream& file_;
    const std::string& path_;
    std::uint64_t size_;
    int version_;
};

struct Variable {
    bool of_records = false;
    std::uint64_t begin = 0;
    double bytes = 0;  ///< of one record, or all
};

Variable read_variable(Header& header, const std::vector<std::uint64_t>& dimensions, const std::string& path) {
    Variable v;
    header.name();
    const std::uint64_t rank = header.count();
    if (rank > header.size()) refuse_short(path, "its header has no end");
    v.bytes = 1;
    for (std::uint64_t k = 0; k < rank; ++k) {
        const std::uint64_t d = header.count();
        if (d >= dimensions.size()) refuse_short(path, "its header names a dimension that it lacks");
        if (k == 0 && dimensions[d] == 0)
            v.of_records = true;
        else
            v.bytes *= static_cast<double>(dimensions[d]);
    }
    header.attributes();
    v.bytes *= static_cast<double>(header.bytes_of(header.tag()));
    header.count();  // vsize: follows from the others, and does not fit large ones
    v.begin = header.place();
    return v;
}

}  // namespace

void check_netcdf_size(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    char magic[4] = {};
    file.read(magic, 4);
    if (file.gcount() != 4 || magic[0] != 'C' || magic[1] != 'D' || magic[2] != 'F') return;
    if (magic[3] != 1 && magic[3] != 2 && magic[3] != 5) return;
    Header header(file, path, magic[3]);
    const std::uint64_t records = header.count();
    std::vector<std::uint64_t> dimensions;
    for (std::uint64_t n = header.list(); n > 0; --n) header.name(), dimensions.push_back(header.count());
    header.attributes();
    std::vector<Variable> variables;
    for (std::uint64_t n = header.list(); n > 0; --n) variables.push_back(read_variable(header, dimensions, path));
    const auto padded = [](double bytes) { return 4 * std::ceil(bytes / 4); };
    const auto of_records =
        std::count_if(variables.begin(), variables.end(), [](const auto& v) { return v.of_records; });
    double record = 0, end = 0;
    for (const Variable& v : variables)
        if (v.of_records) record += of_records == 1 ? v.bytes : padded(v.bytes);
    const bool streaming = records >= 0xFFFFFFFFu;
    for (const Variable& v : variables) {
        const double more = v.of_records ? (streaming ? 0 : static_cast<double>(records) - 1) * record : 0;
        if (!v.of_records || records > 0) end = std::max(end, static_cast<double>(v.begin) + more + v.bytes);
    }
    if (end > static_cast<double>(header.size()))
        refuse_short(path, fmt::format("it has {} bytes, and values up to byte {:.0f}", header.size(), end));
}

}  // namespace moraine
