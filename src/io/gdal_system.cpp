// What a coordinate reference system means for a scene: its units, the direction of its axes, its scale at a place.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/file_numbers.hpp"
#include "io/gdal_library.hpp"
#include "io/gis_file.hpp"
#include "io/input_error.hpp"

namespace moraine {
namespace {

/// From the bracket at `open` to the one that closes it.
std::string_view in_brackets(std::string_view wkt, std::size_t open) {
    int depth = 0;
    for (std::size_t at = open; at < wkt.size(); ++at) {
        depth += wkt[at] == '[' ? 1 : wkt[at] == ']' ? -1 : 0;
        if (depth == 0) return wkt.substr(open, at + 1 - open);
    }
    return wkt.substr(open);
}

/// The word behind the name of AXIS["name (X)",word,...
std::string_view direction_of(std::string_view axis) {
    const std::size_t comma = axis.find("\",");
    if (comma == std::string_view::npos) return {};
    const std::string_view rest = axis.substr(comma + 2);
    return rest.substr(0, rest.find_first_of(",]"));
}

/// An axis may point south on a map of a pole: it says along which meridian.
void check_axes(std::string_view wkt, const std::string& path, const std::string& name) {
    for (std::size_t at = wkt.find("AXIS["); at != std::string_view::npos; at = wkt.find("AXIS[", at + 1)) {
        const std::string_view axis = in_brackets(wkt, at + 4), direction = direction_of(axis);
        if (direction == "down")
            refuse(path, "its vertical axis points down", name + "; scenes have z up",
                   "Turn the sign of its values, and name a system of heights?");
        if ((direction == "south" || direction == "west") && axis.find("MERIDIAN[") == std::string_view::npos)
            refuse(path, fmt::format("an axis points {}", direction), name + "; scenes have x east and y north",
                   "Reproject it, by gdalwarp -t_srs?");
    }
}

void check_vertical_unit(std::string_view wkt, const std::string& path, const std::string& name) {
    const std::size_t vertical = wkt.find("VERTCRS[");
    if (vertical == std::string_view::npos) return;
    const std::string_view part = in_brackets(wkt, vertical + 7);
    const std::size_t unit = part.find("LENGTHUNIT[\"");
    if (unit == std::string_view::npos) return;
    const std::string_view text = in_brackets(part, unit + 10);
    const std::size_t comma = text.find("\",");
    const auto metres = number_in(text.substr(comma + 2, text.find_first_of(",]", comma + 2) - comma - 2));
    if (comma == std::string_view::npos || !metres || std::fabs(*metres - 1) > 1e-9)
        refuse(path, fmt::format("heights in {}", text.substr(2, std::max<std::size_t>(comma, 2) - 2)),
               name + "; scenes are in metres", "Convert them?");
}

constexpr double most_scale = 0.01;  ///< off one

/// Lengths in the system over those on the ground at a place, along x and y; none where that is not known.
std::array<double, 2> scale_at(OGRSpatialReferenceH degrees, OGRCoordinateTransformationH transform, double x,
                               double y) {
    constexpr double step = 1, radians = 0.017453292519943295;
    const double a = gdal().OSRGetSemiMajor(degrees, nullptr), inverse = gdal().OSRGetInvFlattening(degrees, nullptr);
    const double f = inverse > 0 ? 1 / inverse : 0, e2 = f * (2 - f);
    std::array<double, 2> scale{};
    for (int axis = 0; axis < 2; ++axis) {
        double lon[2] = {x - (axis == 0 ? step : 0), x + (axis == 0 ? step : 0)};
        double lat[2] = {y - (axis == 1 ? step : 0), y + (axis == 1 ? step : 0)};
        if (!gdal().OCTTransform(transform, 2, lon, lat, nullptr)) return {};
        const double middle = 0.5 * (lat[0] + lat[1]) * radians, w = std::sqrt(1 - e2 * std::pow(std::sin(middle), 2));
        const double east = a / w * std::cos(middle) * (lon[1] - lon[0]) * radians;
        const double north = a * (1 - e2) / (w * w * w) * (lat[1] - lat[0]) * radians;
        const double ground = std::hypot(east, north);
        if (!(ground > 0) || !std::isfinite(ground)) return {};
        scale[static_cast<std::size_t>(axis)] = 2 * step / ground;
    }
    return scale;
}

}  // namespace

void check_system(OGRSpatialReferenceH system, const std::string& path) {
    if (!system) return;
    const GdalLibrary& g = gdal();
    const std::string remedy = "Reproject it to a metric system, by gdalwarp -t_srs?", name = name_of(system);
    if (g.OSRIsGeographic(system)) refuse(path, "the raster is in degrees", name, remedy);
    char* unit = nullptr;
    if (g.OSRIsProjected(system) && std::fabs(g.OSRGetLinearUnits(system, &unit) - 1) > 1e-9)
        refuse(path, fmt::format("the raster is in {}", unit ? unit : "another unit"),
               fmt::format("{}; scenes are in metres", name), remedy);
    const std::string wkt = wkt_of(system);
    check_axes(wkt, path, name);
    check_vertical_unit(wkt, path, name);
}

void check_scale(const Ground& part, const std::string& path) {
    const GdalSystem system = part.crs.empty() ? nullptr : system_of(part.crs);
    if (!system || !gdal().OSRIsProjected(system.get())) return;
    const GdalSystem degrees(gdal().OSRCloneGeogCS(system.get()));
    if (!degrees) return;
    gdal().OSRSetAxisMappingStrategy(degrees.get(), OAMS_TRADITIONAL_GIS_ORDER);
    const GdalTransform transform(gdal().OCTNewCoordinateTransformation(system.get(), degrees.get()));
    if (!transform) return;
    for (double u : {0.0, 0.5, 1.0})
        for (double v : {0.0, 0.5, 1.0}) {
            const double x = part.first[0] + u * part.spacing * static_cast<double>(part.count[0] - 1);
            const double y = part.first[1] + v * part.spacing * static_cast<double>(part.count[1] - 1);
            for (const double scale : scale_at(degrees.get(), transform.get(), x, y))
                if (scale > 0 && std::fabs(scale - 1) > most_scale)
                    refuse(
                        path,
                        fmt::format("lengths are {:.4g} times those on the ground at ({:.10g}, {:.10g})", scale, x, y),
                        fmt::format("by the projection of {}", name_of(system.get())),
                        "Reproject it to a system of the place, such as its UTM zone, by gdalwarp -t_srs?");
        }
}

bool are_same_crs(const std::string& one, const std::string& other, const std::array<double, 2>& min,
                  const std::array<double, 2>& max, double tolerance) {
    if (one.empty() || other.empty() || one == other) return true;
    const GdalSystem from = system_of(one), to = system_of(other);
    if (!from || !to) return true;
    if (gdal().OSRIsSame(from.get(), to.get())) return true;
    const GdalTransform transform(gdal().OCTNewCoordinateTransformation(from.get(), to.get()));
    if (!transform) return false;
    for (double px : {min[0], max[0]})
        for (double py : {min[1], max[1]}) {
            double x = px, y = py;
            if (!gdal().OCTTransform(transform.get(), 1, &x, &y, nullptr) || !(std::hypot(x - px, y - py) <= tolerance))
                return false;
        }
    return true;
}

std::string crs_beside(const std::string& path) {
    const std::string beside = std::filesystem::path(path).replace_extension(".prj").string();
    std::error_code none;
    if (!std::filesystem::is_regular_file(beside, none)) return {};
    std::string text = text_of(beside, "coordinate system", "terrain.dem", 65536);
    text.erase(0, text.find_first_not_of(" \t\r\n"));
    const GdalSystem system = system_of(text);
    if (!system) refuse(beside, "no coordinate system", gdal_message(), "Remove the file, or mend it?");
    check_system(system.get(), beside);
    return wkt_of(system.get());
}

}  // namespace moraine
