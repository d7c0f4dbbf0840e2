// Keys of [terrain], [[release]], [[inflow]] and [hazard].
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

using enum KeyType;
using S = StructureSpec;
using B = BodySpec;
using V = KeyValue;

const std::vector<KeyRow<StructureSpec>> terrain = in_tables<StructureSpec>({
    {{.table = "terrain",
      .name = "dem",
      .type = text,
      .standard = "",
      .meaning = "In 3-D, where z is up: an ESRI ASCII grid (.asc) or, by GDAL, a GeoTIFF, netCDF or other raster, in "
                 "metres and "
                 "in the scene's coordinates, relative to the scene. Faces without a wall are open."},
     [](S& s, const V& v) { s.file = v.text; }},
    {{.name = "profile",
      .type = text,
      .standard = "",
      .meaning = "In 2-D, where y is up: a .csv with a header x,z and points at even distances."},
     [](S& s, const V& v) { s.file = v.text; }},
    {{.name = "friction",
      .type = text,
      .standard = "",
      .meaning = "A raster of contact.friction (mu), of law coulomb or voellmy, in the model's coordinates; that "
                 "of the contact holds where the raster has no data."},
     [](S& s, const V& v) { s.friction_file = v.text; }},
    {{.name = "xi",
      .type = text,
      .standard = "",
      .meaning = "A raster of contact.xi [m/s2], of law voellmy, as friction."},
     [](S& s, const V& v) { s.xi_file = v.text; }},
    {{.name = "su",
      .type = text,
      .standard = "",
      .meaning = "A raster of contact.su [Pa], of law undrained, as friction."},
     [](S& s, const V& v) { s.su_file = v.text; }},
    {{.name = "crop",
      .type = text,
      .standard = "",
      .meaning = "Polygons in plan, as area of a release: the domain is the box around them, in whole cells, in place "
                 "of domain.min and domain.max."},
     [](S& s, const V& v) { s.crop_file = v.text; }},
    {{.name = "smooth",
      .unit = "m",
      .standard = "",
      .range = {0, std::numeric_limits<double>::infinity(), true, false},
      .meaning =
          "Least radius of curvature wanted: where the model bends more sharply its heights are relaxed. Below 5 "
          "cells check warns; left out: as it is."},
     [](S& s, const V& v) { s.smooth = v.real; }},
    {{.name = "clear",
      .type = truth,
      .standard = "false",
      .meaning =
          "true: particles of bodies that would begin below the ground are left out; false: the scene is refused "
          "then."},
     [](S& s, const V& v) { s.clear = v.truth; }},
});

const std::vector<KeyRow<BodySpec>> releases = in_tables<BodySpec>({
    {{.table = "release", .name = "name", .type = name, .meaning = "By which --set refers to it."},
     [](B& b, const V& v) { b.name = v.text; }},
    // Resolved to Scene::materials by the reader, which knows their names.
    {{.name = "material", .type = name, .meaning = "Name of a material."}, [](B&, const V&) {}},
    {{.name = "area",
      .type = text,
      .meaning =
          "Polygons in plan: a .csv with a header x,y and a row per corner, a .geojson or, by GDAL, a GeoPackage, "
          "shapefile or other; reprojected to the model's coordinates where both are known. Of several "
          "polygons each is a body NAME-1, NAME-2, ...; relative to the scene."},
     [](B& b, const V& v) { b.file = v.text; }},
    {{.name = "thickness",
      .type = real_or_text,
      .unit = "m",
      .standard = "",
      .range = {0, std::numeric_limits<double>::infinity(), true, false},
      .meaning =
          "Normal to the ground; the volume is this times the sloping area. At least a cell; 4 cells and more are "
          "resolved. Or the path of a raster of it; left out: the attribute thickness of the polygons."},
     [](B& b, const V& v) { b.thickness = v.real, b.thickness_raster.file = v.text; }},
    {{.name = "particles_per_cell",
      .type = per_axis,
      .standard = "2",
      .range = {1, 32},
      .meaning = "Along x and y in plan, and along the normal."},
     [](B& b, const V& v) {
         for (std::size_t a = 0; a < v.numbers.size(); ++a) b.particles_per_cell[a] = static_cast<int>(v.numbers[a]);
     }},
    {{.name = "velocity", .type = vector, .unit = "m/s", .standard = "[0, 0, 0]", .meaning = "At the start."},
     [](B& b, const V& v) { b.velocity = v.triple(); }},
    {{.name = "start",
      .unit = "s",
      .standard = "0",
      .range = {0, std::numeric_limits<double>::infinity(), false, false},
      .meaning = "When it is released: it comes in at the end of the first step that ends then or later."},
     [](B& b, const V& v) { b.release_time = v.real; }},
});

const std::vector<KeyRow<BodySpec>> inflows = in_tables<BodySpec>({
    {{.table = "inflow", .name = "name", .type = name, .meaning = "By which --set refers to it."},
     [](B& b, const V& v) { b.name = v.text; }},
    // Resolved to Scene::materials by the reader, which knows their names.
    {{.name = "material", .type = name, .meaning = "Name of a material."}, [](B&, const V&) {}},
    {{.name = "line",
      .type = line,
      .unit = "m",
      .meaning = "Points in plan, at least 2: soil comes in over it, to the left of the way along it."},
     [](B& b, const V& v) { b.points = v.points; }},
    {{.name = "table",
      .type = text,
      .meaning = "A .csv with a header time,discharge,speed and rows in s, m3/s and m/s, between which it is linear; "
                 "before the first and behind the last nothing comes in. Relative to the scene."},
     [](B& b, const V& v) { b.file = v.text; }},
    {{.name = "particles_per_cell",
      .type = per_axis,
      .standard = "2",
      .range = {1, 32},
      .meaning = "Along the flow, along the line and normal to the ground."},
     [](B& b, const V& v) {
         for (std::size_t a = 0; a < v.numbers.size(); ++a) b.particles_per_cell[a] = static_cast<int>(v.numbers[a]);
     }},
});

const std::vector<KeyRow<Scene>> hazards = in_tables<Scene>({
    {{.table = "hazard",
      .name = "cell",
      .unit = "m",
      .range = {0, std::numeric_limits<double>::infinity(), true, false},
      .meaning = "Side of a cell of the maps, which lie on a grid from the first height of the model on; at least "
                 "domain.cell."},
     [](Scene& s, const V& v) { s.hazard.cell = v.real; }},
    {{.name = "maps",
      .type = words,
      .standard = "[\"max_depth\", \"max_speed\", \"max_pressure\", \"max_momentum_flux\", \"arrival\", "
                  "\"deposit\"]",
      .choices = hazard_map_names(),
      .meaning =
          "What is written into maps/NAME.tif (.asc without GDAL), over the whole run: docs/terrain.md has the rules."},
     [](Scene& s, const V& v) { s.hazard.maps = v.words; }},
    {{.name = "threshold",
      .unit = "m",
      .standard = "0.1",
      .range = {0, std::numeric_limits<double>::infinity(), true, false},
      .meaning = "Depth from which a column has been reached, and tells a speed."},
     [](Scene& s, const V& v) { s.hazard.threshold = v.real; }},
    {{.name = "gauges",
      .type = text,
      .standard = "",
      .meaning = "Places in plan: a .csv with a header name,x,y or, by GDAL, points with an attribute name. Depth, "
                 "speed and pressure of their map cells at every sample go into gauges.csv; relative to the scene."},
     [](Scene& s, const V& v) { s.hazard.gauges_file = v.text; }},
    {{.name = "sections",
      .type = text,
      .standard = "",
      .meaning = "Lines in plan: a .csv with a header name,x,y and a row per point, a .geojson or, by GDAL, a "
                 "GeoPackage or other; the attribute name is optional. Discharge, volume and mass that went over each "
                 "line to its left go into sections.csv at every sample; relative to the scene."},
     [](Scene& s, const V& v) { s.hazard.sections_file = v.text; }},
    {{.name = "path",
      .type = text,
      .standard = "",
      .meaning =
          "The way of the flow from its source downwards, one line in a file as that of sections: along it moraine "
          "converge, study and report count front, runout and travel angle, instead of the steepest way from the "
          "releases; relative to the scene."},
     [](Scene& s, const V& v) { s.hazard.path_file = v.text; }},
});

}  // namespace

const std::vector<KeyRow<Scene>>& hazard_rows() {
    return hazards;
}

/// In the order of records/hazard_maps.hpp.
const std::vector<std::string>& hazard_map_names() {
    static const std::vector<std::string> names{"max_depth", "max_speed", "max_pressure",  "max_momentum_flux",
                                                "arrival",   "deposit",   "max_thickness", "deposit_thickness"};
    return names;
}

const std::vector<KeyRow<BodySpec>>& release_rows() {
    return releases;
}
const std::vector<KeyRow<BodySpec>>& inflow_rows() {
    return inflows;
}
const std::vector<KeyRow<StructureSpec>>& terrain_rows() {
    return terrain;
}

}  // namespace moraine
