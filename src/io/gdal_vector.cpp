#include <fmt/format.h>

#include <cmath>

#include "core/data/error.hpp"
#include "io/file_numbers.hpp"
#include "io/gdal_library.hpp"
#include "io/gis_file.hpp"
#include "io/input_error.hpp"

namespace moraine {
namespace {

const char* plural_of(GisKind kind) {
    return kind == GisKind::polygon ? "polygons" : kind == GisKind::line ? "lines" : "points";
}

/// Points of a line or ring, without a last one that closes it.
std::vector<std::array<double, 2>> points_of(OGRGeometryH line, GisKind kind) {
    std::vector<std::array<double, 2>> points;
    const int count = gdal().OGR_G_GetPointCount(line);
    for (int k = 0; k < count; ++k) points.push_back({gdal().OGR_G_GetX(line, k), gdal().OGR_G_GetY(line, k)});
    if (kind == GisKind::polygon && points.size() > 1 && points.front() == points.back()) points.pop_back();
    return points;
}

/// Appends the parts of a geometry, each as a shape.
void add_parts(OGRGeometryH geometry, GisKind kind, const std::string& path, const GisShape& like,
               std::vector<GisShape>& all) {
    const GdalLibrary& g = gdal();
    const OGRwkbGeometryType type = g.OGR_GT_Flatten(g.OGR_G_GetGeometryType(geometry));
    const bool many = type == wkbMultiPolygon || type == wkbMultiLineString || type == wkbMultiPoint;
    const OGRwkbGeometryType wanted = kind == GisKind::polygon ? wkbPolygon
                                      : kind == GisKind::line  ? wkbLineString
                                                               : wkbPoint;
    for (int k = 0; many && k < g.OGR_G_GetGeometryCount(geometry); ++k)
        add_parts(g.OGR_G_GetGeometryRef(geometry, k), kind, path, like, all);
    if (many) return;
    if (type != wanted)
        refuse(path, "a geometry of another kind", fmt::format("only {} are read here", plural_of(kind)),
               "Is it the right file?");
    if (type == wkbPolygon && g.OGR_G_GetGeometryCount(geometry) != 1)
        refuse(path, g.OGR_G_GetGeometryCount(geometry) > 1 ? "a polygon with a hole" : "a polygon without corners",
               "an area is one ring", "Draw it as polygons without holes?");
    GisShape shape = like;
    shape.points = points_of(type == wkbPolygon ? g.OGR_G_GetGeometryRef(geometry, 0) : geometry, kind);
    all.push_back(std::move(shape));
}

/// Name and thickness that a feature says.
GisShape attributes_of(OGRFeatureH feature, const std::string& path) {
    const GdalLibrary& g = gdal();
    GisShape shape;
    const auto field = [&](const char* name) {
        const int at = g.OGR_F_GetFieldIndex(feature, name);
        return at >= 0 && g.OGR_F_IsFieldSetAndNotNull(feature, at) ? at : -1;
    };
    if (const int at = field("name"); at >= 0) shape.name = g.OGR_F_GetFieldAsString(feature, at);
    if (const int at = field("thickness"); at >= 0) {
        const OGRFieldType type = g.OGR_Fld_GetType(g.OGR_F_GetFieldDefnRef(feature, at));
        const std::string text = g.OGR_F_GetFieldAsString(feature, at);
        const bool numeric = type == OFTInteger || type == OFTInteger64 || type == OFTReal;
        const auto value = numeric ? std::optional(g.OGR_F_GetFieldAsDouble(feature, at)) : number_in(text);
        if (!value)
            refuse(path, fmt::format("a thickness of {}", quote(text.substr(0, 40))), "must be a number",
                   "Correct the attribute?");
        shape.thickness = *value;
        if (!(*shape.thickness > 0) || !std::isfinite(*shape.thickness))
            refuse(path, fmt::format("a thickness of {} m", *shape.thickness), "must be > 0", "Correct the attribute?");
    }
    return shape;
}

/// To the system of the model, where both are known.
void reproject(OGRSpatialReferenceH from, const std::string& crs, const std::string& path,
               std::vector<GisShape>& shapes, std::vector<std::string>& notices) {
    const GdalLibrary& g = gdal();
    const GdalSystem to = system_of(crs), source = system_of(wkt_of(from));
    if (!to || !source || g.OSRIsSame(source.get(), to.get())) return;
    const GdalTransform transform(g.OCTNewCoordinateTransformation(source.get(), to.get()));
    const std::string way = fmt::format("from {} to {}, the model's", name_of(source.get()), name_of(to.get()));
    if (!transform) refuse(path, "no way " + way, gdal_message(), "Reproject it, by ogr2ogr -t_srs?");
    for (GisShape& shape : shapes)
        for (auto& p : shape.points) {
            const auto before = p;
            if (!g.OCTTransform(transform.get(), 1, &p[0], &p[1], nullptr) || !std::isfinite(p[0]) ||
                !std::isfinite(p[1]))
                refuse(path, fmt::format("({:.10g}, {:.10g}) cannot be reprojected", before[0], before[1]), way,
                       "Has the file the right coordinate system?");
        }
    notices.push_back(fmt::format("{}: reprojected {}.", path, way));
}

OGRGeometryH ring_of(const std::vector<std::array<double, 2>>& points) {
    OGRGeometryH ring = gdal().OGR_G_CreateGeometry(wkbLinearRing);
    for (const auto& p : points) gdal().OGR_G_AddPoint_2D(ring, p[0], p[1]);
    gdal().OGR_G_AddPoint_2D(ring, points[0][0], points[0][1]);
    return ring;
}

}  // namespace

std::vector<GisShape> read_gis_shapes(const std::string& path, const std::string& key, GisKind kind,
                                      const std::string& crs, std::vector<std::string>& notices) {
    const GdalLibrary& g = gdal();
    const GdalDataset dataset = open_gis_file(path, "file", key, GDAL_OF_VECTOR);
    if (const int layers = g.GDALDatasetGetLayerCount(dataset.get()); layers != 1)
        refuse(path, fmt::format("the file has {} layers", layers), "one is needed", "Extract it by ogr2ogr?");
    OGRLayerH layer = g.GDALDatasetGetLayer(dataset.get(), 0);
    std::vector<GisShape> shapes;
    g.OGR_L_ResetReading(layer);
    const auto destroy = [&](OGRFeatureH f) { g.OGR_F_Destroy(f); };
    while (std::unique_ptr<std::remove_pointer_t<OGRFeatureH>, decltype(destroy)> feature{g.OGR_L_GetNextFeature(layer),
                                                                                          destroy})
        if (OGRGeometryH geometry = g.OGR_F_GetGeometryRef(feature.get()))
            add_parts(geometry, kind, path, attributes_of(feature.get(), path), shapes);
    if (shapes.empty())
        refuse(path, fmt::format("no {} were found", plural_of(kind)), fmt::format("{} needs one", key),
               "Is it the right file?");
    reproject(g.OGR_L_GetSpatialRef(layer), crs, path, shapes, notices);
    return shapes;
}

namespace {

/// GeoPackages hold the time at which they were written: while this lives it is one that says nothing.
struct NoTimeOfDay {
    NoTimeOfDay() { gdal().CPLSetConfigOption("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z"); }
    ~NoTimeOfDay() { gdal().CPLSetConfigOption("OGR_CURRENT_DATE", nullptr); }
    NoTimeOfDay(const NoTimeOfDay&) = delete;
};

OGRGeometryH geometry_of(const std::vector<Rings>& polygons) {
    const GdalLibrary& g = gdal();
    OGRGeometryH all = g.OGR_G_CreateGeometry(wkbMultiPolygon);
    for (const Rings& rings : polygons) {
        OGRGeometryH polygon = g.OGR_G_CreateGeometry(wkbPolygon);
        for (const auto& ring : rings) g.OGR_G_AddGeometryDirectly(polygon, ring_of(ring));
        g.OGR_G_AddGeometryDirectly(all, polygon);
    }
    return all;
}

bool add_field(OGRLayerH layer, const std::string& name, OGRFieldType type) {
    OGRFieldDefnH field = gdal().OGR_Fld_Create(name.c_str(), type);
    const bool good = gdal().OGR_L_CreateField(layer, field, TRUE) == OGRERR_NONE;
    gdal().OGR_Fld_Destroy(field);
    return good;
}

bool add_outline(OGRLayerH layer, const std::vector<Rings>& polygons, double threshold, const MapTags& tags) {
    const GdalLibrary& g = gdal();
    bool good = add_field(layer, "threshold", OFTReal);
    for (const auto& tag : tags) good = good && add_field(layer, tag.first, OFTString);
    if (!good) return false;
    OGRFeatureH feature = g.OGR_F_Create(g.OGR_L_GetLayerDefn(layer));
    g.OGR_F_SetFieldDouble(feature, 0, threshold);
    for (std::size_t k = 0; k < tags.size(); ++k)
        g.OGR_F_SetFieldString(feature, static_cast<int>(k) + 1, tags[k].second.c_str());
    g.OGR_F_SetGeometryDirectly(feature, geometry_of(polygons));
    good = g.OGR_L_CreateFeature(layer, feature) == OGRERR_NONE;
    g.OGR_F_Destroy(feature);
    return good;
}

}  // namespace

std::string outline_bytes(const std::vector<Rings>& polygons, const std::string& crs, double threshold,
                          const MapTags& tags) {
    const GdalLibrary& g = gdal();
    const std::string name = "/vsimem/moraine_outline.gpkg";
    const NoTimeOfDay none;
    GDALDriverH driver = g.GDALGetDriverByName("GPKG");
    GdalDataset dataset(driver ? g.GDALCreate(driver, name.c_str(), 0, 0, 0, GDT_Unknown, nullptr) : nullptr);
    if (!dataset) throw MachineError(fmt::format("GDAL cannot write GeoPackage ({}).", gdal_message()));
    const GdalSystem system = system_of(crs.empty() ? "LOCAL_CS[\"Undefined Cartesian SRS\",UNIT[\"metre\",1]]" : crs);
    OGRLayerH layer = g.GDALDatasetCreateLayer(dataset.get(), "outline", system.get(), wkbMultiPolygon, nullptr);
    if (!layer || !add_outline(layer, polygons, threshold, tags))
        throw MachineError(fmt::format("GDAL cannot write an outline ({}).", gdal_message()));
    dataset.reset();
    return bytes_in_memory(name);
}

}  // namespace moraine
