#include "io/scene_keys.hpp"

#include <cmath>

#include "core/vec.hpp"

namespace moraine {
namespace {

using enum KeyType;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr KeyRange above_zero{0, infinite, true, false};
constexpr KeyRange from_zero{0, infinite, false, false};
constexpr KeyRange share{0, 1, false, false};
const std::vector<std::string> axis_names{"x", "y", "z"};
const std::vector<std::string> lattice_shapes{"box", "polygon", "sphere"};

}  // namespace

Triple KeyValue::triple() const {
    Triple t{};
    for (std::size_t a = 0; a < numbers.size() && a < 3; ++a) t[a] = numbers[a];
    return t;
}

const std::vector<KeyRow<Scene>>& scene_rows() {
    using S = Scene;
    using V = KeyValue;
    static const std::vector<KeyRow<Scene>> rows{
        {{.name = "title", .type = text, .standard = "\"\"", .meaning = "For people."},
         [](S& s, const V& v) { s.title = v.text; }},
        {{.name = "dimensions",
          .type = integer,
          .range = {2, 3},
          .meaning = "2: plane strain, per metre of thickness, y is up; 3: z is up."},
         [](S& s, const V& v) { s.dimensions = static_cast<int>(v.integer); }},
        {{.name = "gravity", .type = vector, .unit = "m/s2", .standard = "[0, 0, 0]", .meaning = "Acceleration."},
         [](S& s, const V& v) { s.gravity = v.triple(); }},
        {{.name = "seed",
          .type = integer,
          .standard = "1",
          .range = from_zero,
          .meaning = "Of jittered seeding; the same seed gives the same particles on any number of ranks."},
         [](S& s, const V& v) { s.seed = static_cast<std::uint64_t>(v.integer); }},

        {{.table = "domain", .name = "min", .type = vector, .unit = "m", .meaning = "Lower corner."},
         [](S& s, const V& v) { s.min = v.triple(); }},
        {{.table = "domain",
          .name = "max",
          .type = vector,
          .unit = "m",
          .meaning = "Upper corner; a whole number of cells from the lower one."},
         [](S& s, const V& v) { s.max = v.triple(); }},
        {{.table = "domain",
          .name = "cell",
          .unit = "m",
          .range = above_zero,
          .meaning = "Side h of a cell of the background grid."},
         [](S& s, const V& v) { s.cell = v.real; }},
        {{.table = "domain",
          .name = "periodic",
          .type = axes,
          .standard = "[]",
          .meaning = "Axes that close on themselves; such a length must be a multiple of 4 cells."},
         [](S& s, const V& v) {
             for (const int a : v.axes) s.periodic[static_cast<std::size_t>(a)] = true;
         }},

        {{.table = "time", .name = "end", .unit = "s", .range = from_zero, .meaning = "Simulated time."},
         [](S& s, const V& v) { s.end = v.real; }},
        {{.table = "time",
          .name = "cfl",
          .standard = "0.5",
          .range = {0, 1.5, true, false},
          .meaning = "dt = cfl h / (c + |v|), the least over all particles. Not together with dt."},
         [](S& s, const V& v) { s.cfl = v.real; }},
        {{.table = "time",
          .name = "dt",
          .unit = "s",
          .standard = "",
          .range = above_zero,
          .meaning = "Fixed time step, instead of cfl."},
         [](S& s, const V& v) { s.dt = v.real; }},

        {{.table = "numerics",
          .name = "shape",
          .type = choice,
          .standard = "\"quadratic\"",
          .choices = {"linear", "gimp", "gimp-contiguous", "quadratic", "cubic"},
          .meaning = "Shape functions: hats, boxes of fixed size, boxes that stretch, B-splines of order 2 or 3."},
         [](S& s, const V& v) { s.shape = static_cast<Shape>(v.choice); }},
        {{.table = "numerics",
          .name = "transfer",
          .type = choice,
          .standard = "\"flip\"",
          .choices = {"flip", "pic", "apic", "tpic"},
          .meaning = "How velocity goes between particles and grid."},
         [](S& s, const V& v) { s.transfer = static_cast<Transfer>(v.choice); }},
        {{.table = "numerics",
          .name = "flip",
          .standard = "1.0",
          .range = share,
          .meaning = "Share of FLIP against PIC; used by transfer flip."},
         [](S& s, const V& v) { s.flip = v.real; }},
        {{.table = "numerics",
          .name = "stress_update",
          .type = choice,
          .standard = "\"usl\"",
          .choices = {"usl", "usf", "musl"},
          .meaning = "Stress last, stress first, or last with velocities mapped a second time."},
         [](S& s, const V& v) { s.stress_update = static_cast<StressUpdate>(v.choice); }},
        {{.table = "numerics",
          .name = "precision",
          .type = choice,
          .standard = "\"double\"",
          .choices = {"single", "double"},
          .meaning = "Of the numbers of particles and nodes."},
         [](S& s, const V& v) { s.precision = static_cast<Precision>(v.choice); }},
        {{.table = "numerics",
          .name = "damping",
          .standard = "0.0",
          .range = share,
          .meaning = "Local non-viscous damping, for quasi-static states; 0: dynamic."},
         [](S& s, const V& v) { s.damping = v.real; }},
        {{.table = "numerics",
          .name = "boundary",
          .type = choice,
          .standard = "\"spline\"",
          .choices = {"spline", "plain"},
          .meaning = "Wide shapes at closed walls: ghost nodes extrapolated, or left free."},
         [](S& s, const V& v) { s.boundary_spline = v.choice == 0; }},

        {{.table = "balance",
          .name = "partitioner",
          .type = choice,
          .standard = "\"morton\"",
          .choices = {"morton", "slabs", "slabs-initial", "shuffle"},
          .meaning = "Who owns which block; shuffle (random) is for tests."},
         [](S& s, const V& v) { s.balance.partitioner = v.text; }},
        {{.table = "balance",
          .name = "weight",
          .type = choice,
          .standard = "\"particles\"",
          .choices = {"particles", "cost"},
          .meaning = "What is balanced: the particles, or the measured cost of blocks."},
         [](S& s, const V& v) { s.balance.weight = v.text; }},
        {{.table = "balance",
          .name = "trigger",
          .type = choice,
          .standard = "\"threshold\"",
          .choices = {"never", "every", "threshold", "planned"},
          .meaning = "When to repartition: never, at every interval, above the threshold, or when it pays."},
         [](S& s, const V& v) { s.balance.trigger = static_cast<Trigger>(v.choice); }},
        {{.table = "balance",
          .name = "interval",
          .type = integer,
          .unit = "steps",
          .standard = "50",
          .range = {1, 1e9},
          .meaning = "Between looks at the balance."},
         [](S& s, const V& v) { s.balance.interval = static_cast<int>(v.integer); }},
        {{.table = "balance",
          .name = "threshold",
          .standard = "1.05",
          .range = {1, infinite},
          .meaning = "Maximum over mean load of the ranks; used by trigger threshold."},
         [](S& s, const V& v) { s.balance.threshold = v.real; }},
        {{.table = "balance",
          .name = "axis",
          .type = choice,
          .standard = "\"x\"",
          .choices = axis_names,
          .meaning = "That slabs cut."},
         [](S& s, const V& v) { s.balance.axis = v.choice; }},

        {{.table = "output",
          .name = "interval",
          .unit = "s",
          .standard = "0.0",
          .range = from_zero,
          .meaning = "Simulated time between outputs; 0: start and end only."},
         [](S& s, const V& v) { s.output.interval = v.real; }},
        {{.table = "output",
          .name = "fields",
          .type = words,
          .standard = "[\"velocity\", \"stress\"]",
          .meaning = "In particles.vtkhdf: velocity, stress, pressure, density, ln_J, mass, volume, body, and what the "
                     "laws remember."},
         [](S& s, const V& v) { s.output.fields = v.words; }},
        {{.table = "output",
          .name = "checkpoint_interval",
          .unit = "s",
          .standard = "0.0",
          .range = from_zero,
          .meaning = "Simulated time between checkpoints; 0: none."},
         [](S& s, const V& v) { s.output.checkpoint_interval = v.real; }},
        {{.table = "output",
          .name = "checkpoint_wall_interval",
          .unit = "s",
          .standard = "0.0",
          .range = from_zero,
          .meaning = "Wall time between checkpoints; 0: none."},
         [](S& s, const V& v) { s.output.checkpoint_wall_interval = v.real; }},
    };
    return rows;
}

const std::vector<KeyRow<MaterialSpec>>& material_rows() {
    using M = MaterialSpec;
    using V = KeyValue;
    static const std::vector<KeyRow<MaterialSpec>> rows{
        {{.table = "material", .name = "name", .type = name, .meaning = "By which bodies and --set refer to it."},
         [](M& m, const V& v) { m.name = v.text; }},
        {{.table = "material",
          .name = "law",
          .type = choice,
          .choices = law_names(),
          .meaning = "Constitutive law; it says which of the keys below are used."},
         [](M& m, const V& v) { m.law = v.text; }},
        {{.table = "material", .name = "density", .unit = "kg/m3", .range = above_zero, .meaning = "Unstrained."},
         [](M& m, const V& v) { m.density = v.real; }},
    };
    return rows;
}

}  // namespace moraine
