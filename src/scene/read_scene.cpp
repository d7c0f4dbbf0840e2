#include "scene/read_scene.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>

#include "core/courant.hpp"
#include "core/data/error.hpp"
#include "core/fluid/grid_pressure.hpp"
#include "core/structures/rigid_body.hpp"
#include "io/input_error.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_defaults.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_laws.hpp"
#include "scene/scene_names.hpp"
#include "scene/scene_profiles.hpp"
#include "scene/scene_set.hpp"
#include "scene/scene_shaking.hpp"
#include "scene/scene_stages.hpp"
#include "scene/scene_tables.hpp"
#include "scene/scene_terrain.hpp"
#include "scene/scene_tractions.hpp"
#include "scene/scene_values.hpp"
#include "scene/table_reader.hpp"
#include "seeding/property_profile.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

toml::table parse_text(const std::string& text, const std::string& path) {
    refuse_deep_keys(text, path);
    try {
        return toml::parse(text, path);
    } catch (const toml::parse_error& error) {
        refuse(fmt::format("{}:{}", path, error.source().begin.line), std::string(error.description()),
               "this is not TOML", "See inputs/first_scene.toml for the form?");
    }
}

class Reader {
  public:
    Reader(const std::string& path, const std::string& text, const std::vector<std::string>& sets,
           const CodeRights& rights)
        : tables_(path, parse_text(text, path), scene_.dimensions) {
        for (const std::string& assignment : sets) apply_set(tables_.root, assignment);
        load_laws(tables_.root, path, rights);
    }

    Scene read(const std::function<void(const Scene&)>& admit) {
        refuse_unknown_keys(tables_.root, tables_.file());
        scene_.source.path = tables_.file();
        scene_.name = std::filesystem::path(tables_.file()).stem().string();
        read_sections();
        check_domain_is_said();
        if (places_.has("time.cfl") && places_.has("time.dt"))
            refuse(places_.of("time.dt"), "time.cfl and time.dt are both given", "a step is by cfl or fixed",
                   "Remove one of them?");
        read_time_tables();
        read_shaking(TableReader::section_table(tables_.root, "shaking"));
        tables_.each_of("material",
                        [&](const toml::table& table, const std::string& path) { read_material(table, path); });
        tables_.each_of("body", [&](const toml::table& table, const std::string& path) { read_body(table, path); });
        tables_.each_of("wall", [&](const toml::table& table, const std::string& path) { read_wall(table, path); });
        read_terrain(TableReader::section_table(tables_.root, "terrain"));
        read_hazard();
        tables_.each_of("release",
                        [&](const toml::table& table, const std::string& path) { read_release(table, path); });
        tables_.each_of("inflow", [&](const toml::table& table, const std::string& path) {
            BodySpec body;
            tables_.read_table(&table, "inflow", path, inflow_rows(), body);
            body.material = material_of(table, path);
            load_inflow(scene_, body, places_);
            scene_.bodies.push_back(std::move(body));
        });
        load_profiles(scene_, places_);
        tables_.each_of("structure",
                        [&](const toml::table& table, const std::string& path) { read_structure(table, path); });
        read_tractions();
        read_stages();
        complete_shaking(scene_, places_);
        if (!places_.has("domain.min")) lay_height(scene_);
        lay_beds();
        complete_profiles(scene_, places_);
        take_defaults(scene_, places_);
        check_scene(scene_, places_);
        if (admit) admit(scene_);
        check_particles(scene_, places_);
        check_structures(scene_, places_);
        check_collisions(scene_, places_);
        check_tractions(scene_, places_);
        close_periodic_axes();
        return scene_;
    }

  private:
    void read_hazard() {
        const toml::table* hazard = TableReader::section_table(tables_.root, "hazard");
        if (!hazard) return;
        tables_.read_table(hazard, "hazard", "hazard", hazard_rows(), scene_);
        check_hazard(scene_, places_);
        load_gauges(scene_, places_);
        load_sections(scene_, places_);
        load_path(scene_, places_);
    }

    /// Of a stage, whose keys are set in `root`.
    Reader(const Reader& scene, toml::table root) : tables_(scene.tables_.file(), std::move(root), scene_.dimensions) {}

    /// Tables that are written once.
    void read_sections() {
        for (const char* section :
             {"", "domain", "time", "rest", "sleep", "water", "numerics", "balance", "output", "run"}) {
            const std::string name = section;
            const bool timed = name == "time" || name == "rest" || name == "sleep";
            const auto& rows = timed ? time_rows() : name == "water" ? water_rows() : scene_rows();
            tables_.read_table(name.empty() ? &tables_.root : TableReader::section_table(tables_.root, name), name,
                               name, rows, scene_);
        }
        scene_.water.on = tables_.root.contains("water");
    }

    void close_periodic_axes() {
        for (std::size_t a = 0; a < 3; ++a)
            if (scene_.periodic[a]) scene_.walls[a][0].kind = scene_.walls[a][1].kind = WallKind::periodic;
    }

    std::vector<TractionText> tractions() {
        std::vector<TractionText> texts;
        tables_.each_of("traction", [&](const toml::table& table, const std::string& path) {
            tables_.read_table(&table, "traction", path, traction_rows(), texts.emplace_back());
        });
        return texts;
    }

    void read_tractions() {
        for (const TractionText& text : tractions()) {
            const std::string path = "traction." + text.spec.name;
            scene_.course.tractions.push_back(complete_traction(scene_, text, path, places_));
            if (!text.table.empty())
                scene_.course.tractions.back().factor = table_named(time_tables_, text.table, path + ".table", places_);
        }
    }

    /// What stages may change: materials and walls, and of `scene` the tractions.
    Scene read_strengths(const Scene& scene) {
        refuse_unknown_keys(tables_.root, tables_.file());
        read_sections();
        tables_.each_of("material",
                        [&](const toml::table& table, const std::string& path) { read_material(table, path); });
        tables_.each_of("wall", [&](const toml::table& table, const std::string& path) { read_wall(table, path); });
        if (tables_.root.contains("terrain")) open_faces(scene_, places_);
        close_periodic_axes();
        scene_.course.tractions = tractions_in_stage(scene, tractions(), places_);
        return scene_;
    }

    /// A wall of a new kind has no keys of its former one.
    static void forget_wall(toml::table& root, const std::string& setting) {
        const std::size_t kind = setting.find(".kind=");
        toml::array* walls = root.contains("wall") ? root.get("wall")->as_array() : nullptr;
        if (!walls || !setting.starts_with("wall.") || kind == std::string::npos) return;
        for (toml::node& wall : *walls)
            if (wall.as_table()->get("face")->value_or(std::string()) == setting.substr(5, kind - 5))
                for (const char* key : {"friction", "alpha", "su", "xi", "density", "material"})
                    wall.as_table()->erase(key);
    }

    /// Each stage sets keys beside those that the ones before have set. Of the table only these are read from then on.
    void read_stages() {
        std::vector<StageText> texts;
        tables_.each_of("stage", [&](const toml::table& table, const std::string& path) {
            StageText text;
            tables_.read_table(&table, "stage", path, stage_rows(), text);
            texts.push_back(std::move(text));
        });
        complete_stages(scene_, texts, places_);
        for (StageSpec& stage : scene_.course.stages) {
            const std::string path = "stage." + stage.name + ".set";
            for (const std::string& setting : stage.set) {
                check_setting(scene_, setting, path, places_);
                forget_wall(tables_.root, setting);
            }
            for (const std::string& setting : stage.set) apply_set(tables_.root, setting, path);
            Reader in_stage(*this, std::move(tables_.root));  // a copy of the table would not know its lines
            const Scene changed = in_stage.read_strengths(scene_);
            tables_.root = std::move(in_stage.tables_.root);
            check_profiles_stay(scene_, changed, path, places_);
            stage.materials = changed.materials;
            stage.walls = changed.walls;
            stage.tractions = changed.course.tractions;
        }
    }

    /// Over terrain a domain may be left out, as a whole.
    void check_domain_is_said() const {
        const bool min = places_.has("domain.min"), max = places_.has("domain.max");
        const toml::node* terrain = tables_.root.get("terrain");
        if ((min && max) || (!min && !max && terrain)) return;
        const std::string missing = min ? "max" : "min";
        refuse(places_.has("domain") ? places_.of("domain") : tables_.file(),
               fmt::format("domain.{} is missing", missing),
               min || max ? fmt::format("domain.{} is there", min ? "min" : "max")
                          : "must be one number for each dimension [m]; only over terrain the domain may be left out",
               fmt::format("Add {} = ... to this table?", missing));
    }

    void read_material(const toml::table& table, const std::string& path) {
        MaterialSpec material;
        tables_.read_table(&table, "material", path, material_rows(), material);
        const LawInfo& law = *find_law(material.law);
        std::vector<ProfileSpec> profiles;
        for (const Parameter& parameter : law.parameters) {
            const SceneKey key = parameter_key(law, parameter);
            const auto number = read_profile(table, path, key, material.parameters.size(), profiles);
            material.parameters.push_back(number ? *number : tables_.read_key(key, &table, path, material.law)->real);
        }
        if (const char* problem = law.problem(material.parameters.data()))
            throw InputError(fmt::format("{}: {}: {}", place_of(table, tables_.file()), path, problem));
        if (TableReader::section_table(table, "density")) {
            if (!may_vary(law, law.parameters.size()))
                refuse(places_.of(path + ".density"), path + ".density is a table",
                       "law " + material.law + " has one density", "Give a number?");
            const auto density = std::find_if(material_rows().begin(), material_rows().end(),
                                              [](const auto& row) { return row.key.name == "density"; });
            material.density = *read_profile(table, path, density->key, law.parameters.size(), profiles);
        }
        for (const ProfileSpec& profile : profiles)
            set_profile(material, static_cast<std::size_t>(profile.property), profile);
        if (material.porosity > 0 && !places_.has(path + ".volumetric")) material.volumetric = Volumetric::grid;
        scene_.materials.push_back(std::move(material));
    }

    /// Of a property of a material that is a table: the number that it is everywhere, or else what stands for it, and
    /// its profile.
    std::optional<double> read_profile(const toml::table& table, const std::string& path, const SceneKey& key,
                                       std::size_t property, std::vector<ProfileSpec>& profiles) {
        const toml::table* nested =
            key.type == KeyType::real_or_profile ? TableReader::section_table(table, key.name) : nullptr;
        if (!nested) return {};
        ProfileSpec profile;
        const std::string inner = path + "." + key.name;
        tables_.read_table(nested, "material.su", inner, profile_rows(), profile);
        if (const std::optional<double> number = check_profile(profile, key, inner, places_)) return number;
        profile.property = static_cast<int>(property);
        profiles.push_back(profile);
        return number_before_bodies(profile, key);
    }

    void read_time_tables() {
        tables_.each_of("table", [&](const toml::table& table, const std::string& path) {
            TableSpec spec;
            tables_.read_table(&table, "table", path, table_rows(), spec);
            spec.rows = complete_table(scene_, spec, path, places_);
            time_tables_.push_back(std::move(spec));
        });
        if (places_.has("gravity_table"))
            scene_.course.gravity = table_of(tables_.root, "gravity_table", "gravity_table");
    }

    void read_shaking(const toml::table* table) {
        if (!table) return;
        tables_.read_table(table, "shaking", "shaking", shaking_rows(), scene_);
        scene_.course.shaking.table = table_of(*table, "table", "shaking.table");
    }

    /// The rows of the table of time that a key of a table names.
    const TimeTable& table_of(const toml::table& table, const std::string& key, const std::string& path) const {
        return table_named(time_tables_, table.get(key)->as_string()->get(), path, places_);
    }

    /// Position of the material that a body or release names.
    int material_of(const toml::table& table, const std::string& path) {
        const std::string wanted = table.get("material")->as_string()->get();
        std::vector<std::string> names;
        for (const MaterialSpec& material : scene_.materials) names.push_back(material.name);
        const auto found = std::find(names.begin(), names.end(), wanted);
        if (found == names.end())
            refuse(places_.of(path + ".material"), fmt::format("{}.material = {}", path, quote(wanted)),
                   "there is no such material", names.empty() ? "Write one as [[material]]?" : suggest(wanted, names));
        return static_cast<int>(found - names.begin());
    }

    void read_body(const toml::table& table, const std::string& path) {
        BodySpec body;
        tables_.read_table(&table, "body", path, body_rows(), body);
        for (const char* part : {"wave", "geostatic"})
            if (const toml::table* nested = TableReader::section_table(table, part))
                tables_.read_table(nested, std::string("body.") + part, path + "." + part, body_rows(), body);
        if (body.seeding == Seeding::lattice) body.jitter = 0;
        if (body.shape == BodyShape::table) body.table_hash = hash_of_file(path_of_file(scene_, body.file));
        body.material = material_of(table, path);
        scene_.bodies.push_back(std::move(body));
    }

    void read_release(const toml::table& table, const std::string& path) {
        BodySpec body;
        tables_.read_table(&table, "release", path, release_rows(), body);
        body.material = material_of(table, path);
        for (BodySpec& part : load_releases(scene_, std::move(body), places_)) {
            const std::string own = "release." + part.name;
            if (own != path && places_.has(own))
                refuse(places_.of(path), fmt::format("{} has a polygon of the name {}", path, part.name),
                       "a release has it, too: " + places_.of(own), "Rename one of them?");
            places_.add(own, places_.of(path));
            scene_.bodies.push_back(std::move(part));
        }
    }

    void read_structure(const toml::table& table, const std::string& path) {
        StructureSpec structure;
        tables_.read_table(&table, "structure", path, structure_rows(), structure);
        for (const char* part : {"contact", "collision", "motion"})
            if (const toml::table* nested = TableReader::section_table(table, part))
                tables_.read_table(nested, std::string("structure.") + part, path + "." + part, structure_rows(),
                                   structure);
        complete_law(scene_, structure, path + ".contact", places_);
        if (const std::string key = path + ".motion.table"; places_.has(key)) {
            for (const char* other : {".motion.times", ".motion.factors"})
                if (places_.has(path + other))
                    refuse(places_.of(path + other), fmt::format("{}{} beside {}", path, other, key),
                           "its rows are in the table", "Remove one of them?");
            structure.motion.factor = table_of(*TableReader::section_table(table, "motion"), "table", key);
        }
        if (structure.motion.density > 0)
            structure.motion.mass = structure.motion.density * volume_of(structure, scene_.dimensions);
        scene_.structures.push_back(std::move(structure));
    }

    void read_terrain(const toml::table* table) {
        if (!table) return;
        StructureSpec terrain;
        tables_.read_table(table, "terrain", "terrain", terrain_rows(), terrain);
        if (const toml::table* contact = TableReader::section_table(*table, "contact"))
            tables_.read_table(contact, "structure.contact", "terrain.contact", structure_rows(), terrain);
        complete_law(scene_, terrain, "terrain.contact", places_);
        load_ground(scene_, terrain, places_);
        open_faces(scene_, places_);
        scene_.structures.push_back(std::move(terrain));
    }

    void read_wall(const toml::table& table, const std::string& path) {
        FacedWall faced;
        tables_.read_table(&table, "wall", path, wall_rows(), faced);
        if (faced.face / 2 >= scene_.dimensions)
            refuse(places_.of(path), fmt::format("{} is not there", path), "the scene has 2 dimensions",
                   "Use x-min, x-max, y-min or y-max?");
        scene_.walls[static_cast<std::size_t>(faced.face / 2)][static_cast<std::size_t>(faced.face % 2)] = faced.wall;
        if (faced.bed.law == InterfaceLaw::smooth) return;
        complete_law(scene_, faced.bed, path, places_);
        faced.bed.name = "wall-" + path.substr(path.find('.') + 1);
        places_.add("structure." + faced.bed.name, places_.of(path));
        beds_.push_back(std::move(faced));
    }

    /// Planes at the faces of walls that have a law of structures, once the domain is known.
    void lay_beds() {
        for (FacedWall& faced : beds_) {
            const auto a = static_cast<std::size_t>(faced.face / 2);
            const bool upper = faced.face % 2 == 1;
            faced.bed.shape = StructureShape::plane;
            faced.bed.point = scene_.min;
            faced.bed.point[a] = upper ? scene_.max[a] : scene_.min[a];
            faced.bed.normal = {0, 0, 0};
            faced.bed.normal[a] = upper ? -1 : 1;
            scene_.structures.push_back(std::move(faced.bed));
        }
    }

    Scene scene_;
    TableReader tables_;
    Places& places_ = tables_.places;
    std::vector<TableSpec> time_tables_;
    std::vector<FacedWall> beds_;  ///< that have a law of structures
};

}  // namespace

Scene read_scene(const std::string& path, const std::vector<std::string>& sets,
                 const std::function<void(const Scene&)>& admit, const CodeRights& rights) {
    return parse_scene(path, read_scene_file(path), sets, admit, rights);
}

Scene parse_scene(const std::string& path, const std::string& text, const std::vector<std::string>& sets,
                  const std::function<void(const Scene&)>& admit, const CodeRights& rights) {
    return Reader(path, text, sets, rights).read(admit);
}

}  // namespace moraine
