#pragma once
// What [terrain] and [[release]] mean beyond their keys: files are read, and faces without a wall are open. Not
// collective.

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"

namespace moraine {

/// Reads the model that the spec names, of the part that the domain needs, and rasters of the bed; a domain that the
/// scene does not say is laid in plan. Throws InputError.
void load_ground(Scene& scene, StructureSpec& spec, const Places& places);

/// Lays a domain in plan over the model, or over terrain.crop. Throws InputError.
void lay_domain(Scene& scene, const StructureSpec& spec, const Ground& all, const Places& places);

/// And in height, by the ground and the bodies on it.
void lay_height(Scene& scene);

/// Refuses a file that is not there, where the scene names it. Throws InputError.
void require_file(const Scene& scene, const std::string& file, const std::string& key, const Places& places);

/// Does what terrain.smooth asks for. Throws InputError.
void smooth_model(Scene& scene, const StructureSpec& spec, const std::string& path, Ground& ground,
                  const Places& places);

/// Reads the polygons of a release: one body for each, of its name, or NAME-1, NAME-2, ... The terrain is
/// scene.structures[0]. Throws InputError.
std::vector<BodySpec> load_releases(Scene& scene, BodySpec spec, const Places& places);

/// Reads the table of an inflow over the terrain, which is scene.structures[0]. Throws InputError.
void load_inflow(Scene& scene, BodySpec& spec, const Places& places);

/// Reads the gauges of [hazard]. Throws InputError.
void load_gauges(Scene& scene, const Places& places);

/// Reads the sections of [hazard]. Throws InputError.
void load_sections(Scene& scene, const Places& places);

/// Reads the path of [hazard]. Throws InputError.
void load_path(Scene& scene, const Places& places);

/// What holds between [hazard] and the rest; lays the grid of the maps. Throws InputError.
void check_hazard(Scene& scene, const Places& places);

/// Over terrain a face that the scene does not name is open: what flows out of the model is counted and gone.
void open_faces(Scene& scene, const Places& places);

/// What the keys of a contact leave to the rest of the scene. `path`: of the contact's keys. Throws InputError.
void complete_law(const Scene& scene, StructureSpec& spec, const std::string& path, const Places& places);

}  // namespace moraine
