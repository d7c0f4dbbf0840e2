// What a file may have GDAL open: itself, and what lies beside it. Texts inside of a file that name others are read
// here before GDAL reads them, and refused where they lead out of its folder.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "io/file_numbers.hpp"
#include "io/gdal_library.hpp"
#include "io/h5_open.hpp"
#include "io/input_error.hpp"
#include "io/netcdf_size.hpp"

namespace moraine {

namespace fs = std::filesystem;

namespace {

constexpr std::streamoff most_text = 16 << 20;

/// GDAL looks for files of the same stem: reading from a pipe would wait for ever.
void check_neighbours(const fs::path& path) {
    const std::string stem = path.stem().string();
    std::error_code none;
    const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
    for (const auto& entry : fs::directory_iterator(folder, none)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(stem + ".") || entry.is_regular_file(none) || entry.is_directory(none)) continue;
        refuse(path.string(), fmt::format("{} beside it is not a regular file", name), "GDAL would read it",
               "Remove or rename it?");
    }
}

[[noreturn]] void refuse_vrt(const std::string& path, const std::string& why) {
    refuse(path, "a virtual raster that is not read here", why,
           "Make one file of it, by gdal_translate -of GTiff, on a machine that may open its sources?");
}

void check_vrt(const std::string& path, int depth);

/// Of either kind.
void check_netcdf(const std::string& path) {
    check_netcdf_size(path);
    check_hdf5_links(path);
}

/// Of a VRT: a plain file of its folder.
void check_vrt_source(const std::string& path, const std::string& name, int depth) {
    const bool plain = !name.empty() && name.find_first_of("&<>:?") == std::string::npos && !name.starts_with("/vsi");
    if (!plain) refuse_vrt(path, fmt::format("its source {} is no plain file", quote(name.substr(0, 80))));
    const fs::path folder = fs::weakly_canonical(fs::absolute(path)).parent_path();
    const fs::path source = fs::weakly_canonical(fs::path(name).is_absolute() ? fs::path(name) : folder / name);
    const auto [end, of_source] = std::mismatch(folder.begin(), folder.end(), source.begin(), source.end());
    if (end != folder.end())
        refuse_vrt(path, fmt::format("its source {} lies outside of its folder", quote(name.substr(0, 80))));
    std::error_code none;
    if (!fs::is_regular_file(source, none))
        refuse_vrt(path, fmt::format("its source {} is not there", quote(name.substr(0, 80))));
    check_neighbours(source);
    check_netcdf(source.string());
    check_vrt(source.string(), depth + 1);
}

/// Plain mosaics and windows of files of its folder; nothing that computes or opens by other ways.
void check_vrt(const std::string& path, int depth) {
    const std::string head = lower_case(text_of(path, "raster", "the file", 4096));
    if (head.find("<vrtdataset") == std::string::npos) return;
    if (depth > 4) refuse_vrt(path, "virtual rasters within virtual rasters");
    const std::string text = text_of(path, "raster", "the file", most_text), low = lower_case(text);
    if (static_cast<std::streamoff>(text.size()) >= most_text) refuse_vrt(path, "it is larger than 16 MB");
    for (const char* word :
         {"subclass", "sourcedataset", "<overview", "<maskband", "<group", "<!", "<pixelfunction", "openoptions"})
        if (low.find(word) != std::string::npos) refuse_vrt(path, fmt::format("it has {}", quote(word)));
    const std::string key = "sourcefilename";
    for (std::size_t at = low.find(key); at != std::string::npos; at = low.find(key, at + 1)) {
        if (at > 1 && low.compare(at - 2, 2, "</") == 0) continue;
        const std::size_t open = low.find('>', at), close = low.find('<', at);
        if (at == 0 || low[at - 1] != '<' || open == std::string::npos || close == std::string::npos || close < open)
            refuse_vrt(path, "it names a source in an unknown way");
        check_vrt_source(path, text.substr(open + 1, close - open - 1), depth);
    }
}

/// The system of a GeoJSON may be a link, which GDAL would follow.
void check_json(const std::string& path) {
    if (!has_ending(path, ".geojson") && !has_ending(path, ".json")) return;
    const std::string text = text_of(path, "file", "the file");
    for (std::size_t at = text.find("\"crs\""); at != std::string::npos; at = text.find("\"crs\"", at + 1)) {
        const std::string crs = lower_case(std::string_view(text).substr(at, 400));
        const std::size_t link = crs.find("://");
        const bool known = link == std::string::npos || crs.compare(link, 19, "://www.opengis.net/") == 0;
        if (!known || crs.find("\"link\"") != std::string::npos || crs.find("\"url\"") != std::string::npos)
            refuse(path, "its coordinate system is a link", "nothing is read from the network",
                   "Name it, as urn:ogc:def:crs:EPSG::32632?");
    }
}

}  // namespace

void check_source(const std::string& path) {
    check_neighbours(path);
    check_netcdf(path);
    check_vrt(path, 0);
    check_json(path);
}

}  // namespace moraine
