#pragma once
// A scene: what to simulate, in SI units, after all keys have been read and checked (scene/read_scene.hpp
// reads it from TOML; inputs/reference.toml says what each key means). Plain data, no behaviour.
// A 2-D scene leaves the third components at zero.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/data/scene_choices.hpp"
#include "core/data/time_table.hpp"
#include "core/material/point.hpp"

namespace moraine {

using Triple = std::array<double, 3>;

struct Ground;  // core/structures/ground.hpp

struct WallSpec {
    WallKind kind = WallKind::none;  ///< none: closed, and a particle that gets there is an error
    double friction = 0;             ///< Coulomb coefficient [-]
    bool absorbs = false;            ///< of kind law, too, but by core/nodes/absorbing_ends.hpp
    std::string material = {};       ///< absorbs: of what is behind it; empty: the soil beside it goes on
    bool drains = false;             ///< water passes (core/nodes/water_nodes.hpp)
};

/// A property of a material over depth or place, instead of one number (seeding/property_profile.hpp).
struct ProfileSpec {
    int property = -1;                     ///< position of the law's parameter; as many as it has: the density
    int scalar = 0;                        ///< of the law's, that holds it
    double surface = 0;                    ///< at no depth [the property's unit]
    double gradient = 0;                   ///< [its unit / m]
    std::vector<double> depth, value;      ///< a table in place of both, linear between its rows [m, its unit]
    std::optional<double> from;            ///< height at which depth begins [m]; none: the body's own surface
    std::string file;                      ///< raster in place of `surface`
    std::shared_ptr<const Ground> raster;  ///< of the file, where heights would be

    bool counts_depth() const { return gradient != 0 || !depth.empty(); }
};

struct MaterialSpec {
    std::string name;
    std::string law;                               ///< a name of core/material/laws.hpp
    double density = 0;                            ///< at ln J = 0; of a profile the least [kg/m3]
    std::vector<double> parameters;                ///< in the order of the law's table; of a profile the greatest
    Volumetric volumetric = Volumetric::particle;  ///< of rate and pressure (core/grid/volumetric.hpp)
    double pressure_smoothing = 0;                 ///< k of core/fluid/pressure_smoothing.hpp [-]
    double particle_shifting = 0;                  ///< gamma of core/fluid/particle_shifting.hpp [-]
    std::vector<ProfileSpec> profiles;             ///< what is no single number, by property
    bool keeps_strength = false;                   ///< contacts follow its undrained strength as it is now
    double porosity = 0;                           ///< at ln J = 0, of soil full of water; 0: without [-]
    double conductivity = 0;                       ///< k of Darcy's law, of such soil [m/s]

    /// nullptr: the property is one number.
    const ProfileSpec* profile_of(std::size_t property) const {
        for (const ProfileSpec& p : profiles)
            if (p.property == static_cast<int>(property)) return &p;
        return nullptr;
    }
    const ProfileSpec* density_profile() const { return profile_of(parameters.size()); }
};

/// Water in the pores of the ground (core/fluid/water_cells.hpp).
struct WaterSpec {
    bool on = false;
    std::optional<double> table;  ///< height of still water at the start; none: pore pressure begins at 0 [m]
    double density = 1000;        ///< [kg/m3]
    double bulk = 2.2e9;          ///< [Pa]
    double cavitation = 1e5;      ///< tension that it bears at most, below the air's pressure [Pa]
    bool submerged = false;       ///< still water stands above all soil: pressures are in excess of it
};

/// By axis, and there the lower and the upper face.
using WallSpecs = std::array<std::array<WallSpec, 2>, 3>;

/// Whether its particles take anything of core/fluid/pressure_smoothing.hpp and particle_shifting.hpp.
inline bool has_fluid_terms(const MaterialSpec& material) {
    return material.pressure_smoothing > 0 || material.particle_shifting > 0;
}

/// v += velocity * sin(2 pi (x[axis] - origin) / wavelength) at the start.
struct WaveSpec {
    Triple velocity{};
    int axis = 0;
    double origin = 0;
    double wavelength = 0;  ///< [m]; 0: no wave
};

/// What comes in over time, linear between its rows.
struct Hydrograph {
    std::vector<double> time, discharge, speed;  ///< [s, m3/s, m/s]
    double volume = 0;                           ///< until the end of the run [m3]
};

/// A raster in a file, and what it holds; none where the scene names none.
struct RasterSpec {
    std::string file;
    std::shared_ptr<const Ground> values;
};

struct BodySpec {
    std::string name;
    int material = 0;  ///< index into Scene::materials
    BodyShape shape = BodyShape::box;
    Triple min{}, max{};                        ///< box [m]; polygon in 3-D: min[2], max[2] are its ends
    Triple center{};                            ///< sphere (2-D: disk) [m]
    double radius = 0;                          ///< [m]
    std::vector<std::array<double, 2>> points;  ///< polygon, layer: in x, y, either sense; inflow: a line [m]
    std::string file;                      ///< table: path of .csv or .h5; layer: of its polygon; inflow: of its table
    std::uint64_t table_hash = 0;          ///< table: of the bytes of its file as the scene was read; 0: of no file
    double thickness = 0;                  ///< layer, inflow: normal to the ground, largest [m]
    RasterSpec thickness_raster;           ///< layer: thickness in place of heights; no values: the same everywhere
    std::shared_ptr<const Ground> ground;  ///< layer, inflow
    std::shared_ptr<const Hydrograph> hydrograph;  ///< inflow
    double release_time = 0;                       ///< layer [s]
    int stage = 0;                                 ///< as whose part it comes in: its place in CourseSpec::stages
    std::array<int, 3> particles_per_cell{2, 2, 2};
    Seeding seeding = Seeding::lattice;
    double jitter = 0;  ///< largest offset, fraction of the particle spacing, 0 to 0.5
    Triple velocity{};  ///< [m/s]
    WaveSpec wave;
    bool geostatic = false;        ///< start from sigma_v = -rho g (surface - y), sigma_h = k0 sigma_v
    double geostatic_surface = 0;  ///< height of the free surface along -gravity's main axis [m]
    double geostatic_k0 = 1;
    BodyStart start;  ///< of the law's scalars
};

/// What a structure has where it meets others (core/structures/collisions.hpp): of two the smaller.
struct CollisionSpec {
    double friction = 0;     ///< Coulomb coefficient [-]
    double restitution = 0;  ///< Newton's: speed after over speed before [-]
};

/// How a structure moves (core/structures/structure_motion.hpp).
struct MotionSpec {
    StructureMotion kind = StructureMotion::fixed;
    Triple velocity{};                       ///< velocity, table: its direction and unit; free: at the start [m/s]
    double ramp = 0;                         ///< velocity: time of the rise [s]
    Triple amplitude{};                      ///< sinusoid [m]
    double period = 0;                       ///< sinusoid [s]
    TimeTable factor;                        ///< table: of the velocity
    double mass = 0;                         ///< free [kg]
    Triple force{};                          ///< free: besides gravity and contact [N]
    double density = 0;                      ///< free: in place of the mass [kg/m3]
    bool turns = false;                      ///< free
    std::vector<double> inertia;             ///< principal, about the axes of the scene; empty: of the shape [kg m2]
    std::vector<double> angular_velocity;    ///< velocity, table: as velocity; free: at the start; one in 2-D [rad/s]
    std::optional<CollisionSpec> collision;  ///< none: it goes through others
};

inline bool turns(const MotionSpec& m) {
    return m.turns || !m.angular_velocity.empty();
}

struct StructureSpec {
    std::string name;
    StructureShape shape = StructureShape::plane;
    Triple point{}, normal{};                   ///< plane: away from the structure
    Triple center{};                            ///< sphere [m]
    double radius = 0;                          ///< sphere, cylinder, capsule [m]
    Triple from{}, to{};                        ///< cylinder, capsule: ends of the axis [m]
    Triple min{}, max{};                        ///< box; polygon in 3-D: min[2], max[2] are its ends [m]
    std::vector<std::array<double, 2>> points;  ///< polygon in x, y, either sense [m]
    bool clear = false;                         ///< particles that begin inside are removed
    std::string file;                           ///< ground: path, absolute or relative to the scene
    std::shared_ptr<const Ground> ground;
    std::string friction_file, xi_file, su_file;  ///< ground: rasters
    std::string crop_file;                        ///< ground: polygon around which the domain is laid
    double smooth = 0;                            ///< ground: least radius of curvature wanted [m]; 0: as it is
    InterfaceLaw law = InterfaceLaw::smooth;
    double friction = 0;   ///< coulomb, voellmy: mu [-]
    double alpha = 0;      ///< undrained: share of su [-]
    double su = 0;         ///< undrained [Pa]
    bool soil_su = false;  ///< undrained: that of the soil beside it, and su the greatest that any has at the start
    double xi = 0;         ///< voellmy [m/s2]
    double density = 0;    ///< voellmy: rho [kg/m3]
    MotionSpec motion;
};

struct OutputSpec {
    double interval = 0;            ///< [s]; 0: start and end only
    double structure_interval = 0;  ///< of structures.csv [s]; 0: that of the others
    std::vector<std::string> fields;
    bool on_cells = false;                ///< cells.vtkhdf instead of particles.vtkhdf
    std::vector<std::string> labels;      ///< of id, rank, block_key
    bool single = false;                  ///< reals of particles.vtkhdf have 4 bytes
    std::int64_t every = 1;               ///< one particle of so many is in particles.vtkhdf
    bool deflate = false;                 ///< particles.vtkhdf is compressed (io/deflate.hpp)
    bool asynchronous = false;            ///< and written while steps are made
    double checkpoint_interval = 0;       ///< [s]; 0: none
    double checkpoint_wall_interval = 0;  ///< [s of wall time]; 0: none
    bool block_loads = false;             ///< record them at each balance interval, for replays
    bool sleep_forecast = false;          ///< with who would sleep, of a run in which all are awake
    bool energy_budget = false;           ///< who took energy, in history.csv (core/nodes/node_energy.hpp)
};

/// When a run is at rest (simulation/rest_watch.hpp).
struct RestSpec {
    bool stops = false;          ///< and ends there
    double displacement = 0.05;  ///< of what rests, within an interval, below that [cells]
    double mass = 0.999;         ///< share that must rest
    double interval = 0;         ///< [s]; 0: by core/rest_interval.hpp
    int intervals = 3;           ///< in turn
};

/// Which blocks sleep (core/sleep/sleep.hpp).
struct SleepSpec {
    bool on = false;
    double displacement = 0.005;  ///< of what may sleep, between two sleep checks, below that [cells]
    double stress = 0.1;          ///< and the change of its stress, of the weight of a block on its face [-]
    double interval = 0;          ///< between sleep checks [s]; 0: by core/sleep/sleep.hpp
    double wake = 2;              ///< a sleeper wakes where its surroundings exceed these so many times
};

/// A place in plan where a run over terrain is observed.
struct GaugeSpec {
    std::string name;
    double x = 0, y = 0;  ///< [m]
};

/// A line in plan; what goes over it to its left is counted (records/section_flow.hpp).
struct SectionSpec {
    std::string name;
    std::vector<std::array<double, 2>> points;  ///< [m]
};

/// Maps of a run over terrain (records/hazard_maps.hpp).
struct HazardSpec {
    double cell = 0;                 ///< side of a cell of the maps [m]; 0: none
    std::array<double, 2> origin{};  ///< corner of a cell of the maps: the first height of the model [m]
    double threshold = 0.1;          ///< depth from which the flow has arrived [m]
    std::vector<std::string> maps;
    std::string gauges_file;
    std::vector<GaugeSpec> gauges;
    std::string sections_file;
    std::vector<SectionSpec> sections;
    std::string path_file;
    std::vector<std::array<double, 2>> path;  ///< along which way is counted; empty: none is given
};

struct BalanceSpec {
    std::string partitioner = "morton";
    std::string weight = "particles";  ///< particles, cost, time
    Trigger trigger = Trigger::threshold;
    int interval = 50;        ///< [steps] between imbalance checks (threshold, planned) or repartitions (every)
    double threshold = 1.05;  ///< max/mean
    int axis = 0;             ///< of slabs
};

/// A traction on a flat part of a body's surface (core/particles/traction.hpp).
struct TractionSpec {
    std::string name;
    int body = 0;                             ///< its place in Scene::bodies
    Triple normal{};                          ///< outward at the start, of length 1
    std::vector<std::array<double, 2>> area;  ///< polygon in x, y around the loaded part; empty: all that faces so [m]
    double pressure = 0;                      ///< inward [Pa]
    Triple shear{};                           ///< along the surface [Pa]
    bool follows = false;                     ///< turns with the surface, per area of now
    double depth = 0;                         ///< of the soil that takes it [m]
    double spacing = 0;                       ///< of the body's particles along the normal [m]
    TimeTable factor;                         ///< empty: 1
};

/// A part of a run: what holds from the end of the stage before to its own (simulation/simulation_stages.cpp).
struct StageSpec {
    std::string name;
    double until = 0;              ///< ends with the first step at or past it; of the last one, the end of the run [s]
    bool until_rest = false;       ///< or sooner, once all has come to rest
    double damping = 0;            ///< in place of Scene::damping
    std::vector<std::string> set;  ///< KEY=VALUE, since the stage before
    std::vector<MaterialSpec> materials;  ///< in place of Scene::materials
    WallSpecs walls;                      ///< in place of Scene::walls
    std::vector<TractionSpec> tractions;  ///< in place of those of CourseSpec
    std::vector<int> removes;             ///< bodies that are taken away as it begins
};

/// What a table of shaking is the motion of: the base itself, rock where it crops out, or the wave that comes up in it.
enum class BaseMotion { base, outcrop, upgoing };

/// A base that shakes (core/gravity.hpp).
struct ShakingSpec {
    TimeTable table;           ///< acceleration or velocity along `direction` [m/s2, m/s]; empty: none
    bool of_velocity = false;  ///< what the table is of
    Triple direction{};        ///< of length 1
    BaseMotion motion = BaseMotion::base;
    bool keeps_drift = false;  ///< the base need not come back to rest where it was
    std::string stage_name;    ///< with whose begin the table begins; empty: with the run
    int stage = -1;            ///< its place; -1: the run's
};

/// What of a scene changes over time.
struct CourseSpec {
    TimeTable gravity;  ///< factor of Scene::gravity; empty: 1
    std::vector<TractionSpec> tractions;
    ShakingSpec shaking;
    std::vector<StageSpec> stages;  ///< in order; empty: the run is one
};

/// What a scene says of itself, and where.
struct SceneSource {
    std::string title;
    std::string path;  ///< of the file
};

struct Scene {
    std::string name;  ///< file name without .toml
    SceneSource source;
    int dimensions = 3;
    Triple min{}, max{};  ///< domain [m]
    double cell = 0;      ///< h [m]
    std::array<bool, 3> periodic{};
    WallSpecs walls{};
    double end = 0;    ///< [s]
    double cfl = 0.5;  ///< dt = cfl h / (c + |v|)
    double dt = 0;     ///< fixed time step [s]; 0: by cfl
    Shape shape = Shape::quadratic;
    Transfer transfer = Transfer::apic;
    double flip = 1;   ///< share of FLIP against PIC
    int order = 2;     ///< terms of FMPM's series
    int substeps = 1;  ///< most of a step (core/fluid/grid_pressure.hpp)
    Bed bed = Bed::nodes;
    StressUpdate stress_update = StressUpdate::usl;
    Precision precision = Precision::double_;
    double damping = 0;              ///< local non-viscous damping [-], 0 to 1; 0: dynamic
    bool limits_light_nodes = true;  ///< core/grid/light_nodes.hpp
    bool boundary_spline = true;     ///< fold ghost nodes at closed walls by linear extrapolation
    Triple gravity{};                ///< [m/s2]
    CourseSpec course;
    WaterSpec water;
    std::vector<MaterialSpec> materials;
    std::vector<BodySpec> bodies;
    std::vector<StructureSpec> structures;
    RestSpec rest;
    SleepSpec sleep;
    OutputSpec output;
    HazardSpec hazard;
    BalanceSpec balance;
    std::vector<std::string> notices;  ///< what a reader of the scene is told; no part of it
    std::uint64_t seed = 1;
    double watchdog = 0;  ///< [s of wall time] without a finished step that end a run; 0: none
};

/// Whether the pressure of some material is the grid's (core/fluid/grid_pressure.hpp).
inline bool uses_grid_pressure(const Scene& scene) {
    bool uses = false;
    for (const MaterialSpec& m : scene.materials) uses = uses || m.volumetric == Volumetric::grid;
    return uses;
}

}  // namespace moraine
