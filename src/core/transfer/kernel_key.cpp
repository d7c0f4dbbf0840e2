#include "core/transfer/kernel_key.hpp"

#include "core/transfer/method.hpp"

namespace moraine {

namespace {

/// Whether a scene with this material alone would be fused.
bool fuses_alone(const Scene& scene, const MaterialSpec& m) {
    const bool plain = scene.transfer == Transfer::flip || scene.transfer == Transfer::pic;
    const bool affine = scene.transfer == Transfer::apic || scene.transfer == Transfer::tpic;
    if (scene.stress_update != StressUpdate::usl) return false;
    if ((has_fluid_terms(m) || m.volumetric == Volumetric::grid) && !find_law(m.law)->is_fluid) return false;
    if (scene.shape == Shape::quadratic) return plain || affine;
    return scene.shape == Shape::linear && plain && !has_fluid_terms(m);
}

bool is_plain(const MaterialSpec& material) {
    return !find_law(material.law)->of_file() &&
           with_law<double>(material.law, material.parameters.data(), [](const auto& law) {
               if constexpr (Undrained<std::decay_t<decltype(law)>>)
                   return !law.strength.depends_on_rate && !law.strength.softens;
               else
                   return false;
           });
}

/// Plain: in all stages.
LawKey law_key(const Scene& scene, std::size_t k) {
    const MaterialSpec& material = scene.materials[k];
    const std::vector<StageSpec>& stages = scene.course.stages;
    const bool plain = is_plain(material) && std::all_of(stages.begin(), stages.end(), [&](const StageSpec& stage) {
                           return is_plain(stage.materials[k]);
                       });
    return {material.law, find_law(material.law), plain, material.volumetric == Volumetric::cell};
}

const char* name_of(Shape shape) {
    switch (shape) {
        case Shape::linear:
            return "linear";
        case Shape::quadratic:
            return "quadratic";
        case Shape::cubic:
            return "cubic";
        default:
            return "gimp";
    }
}

}  // namespace

GatherWay gather_way(const Scene& scene) {
    const std::vector<MaterialSpec>& all = scene.materials;
    if (all.size() == 1) return fuses_alone(scene, all.front()) ? GatherWay::fused : GatherWay::split;
    const bool each = std::all_of(all.begin(), all.end(), [&](const MaterialSpec& m) {
        // What a fluid takes of the grid is asked of all particles of a scene.
        return !has_fluid_terms(m) && m.volumetric != Volumetric::grid && fuses_alone(scene, m);
    });
    return each && !all.empty() ? GatherWay::by_material : GatherWay::split;
}

KernelKey kernel_key(const Scene& scene) {
    KernelKey key{};
    key.real = scene.precision;
    key.dimension = scene.dimensions;
    key.shape = scene.shape;
    key.affine = is_affine(scene.transfer);
    for (std::size_t k = 0; k < scene.materials.size(); ++k) key.laws.push_back(law_key(scene, k));
    key.way = gather_way(scene);
    key.fluid = uses_grid_pressure(scene) ? FluidGrid::pressure
                : has_fluid_terms(scene)  ? FluidGrid::means
                                          : FluidGrid::none;
    key.cell_means = std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const BodySpec& b) {
        return scene.materials[static_cast<std::size_t>(b.material)].volumetric == Volumetric::cell;
    });
    key.light_nodes = limits_accelerations(scene);
    key.structures = !scene.structures.empty();
    key.turning = std::any_of(scene.structures.begin(), scene.structures.end(),
                              [](const StructureSpec& s) { return turns(s.motion); });
    key.surfaces = key.structures && scene.bed == Bed::surface;
    key.sleep = scene.sleep.on;
    key.loads = !scene.course.tractions.empty();
    key.single_round = rounds_of(scene).size() == 1;
    return key;
}

std::string KernelKey::text() const {
    std::string words = std::string(real == Precision::single_ ? "single" : "double") + " " +
                        std::to_string(dimension) + "-D " + name_of(shape) + (affine ? " affine" : "");
    for (std::size_t k = 0; k < laws.size(); ++k)
        words += (k == 0 ? ", " : " + ") + laws[k].name + (laws[k].plain ? " (plain)" : "");
    words += way == GatherWay::fused   ? ", stress in the gather"
             : way == GatherWay::split ? ", stress apart"
                                       : ", stress in the gather of blocks of one material";
    std::string terms;
    const auto add = [&](bool is, const char* term) {
        if (is) terms += (terms.empty() ? "; " : ", ") + std::string(term);
    };
    add(light_nodes, "light nodes"), add(cell_means, "means of cells"),
        add(fluid == FluidGrid::means, "means of nodes");
    add(fluid == FluidGrid::pressure, "pressure on the grid"), add(structures, "contact"), add(turning, "turning"),
        add(surfaces, "surfaces"), add(sleep, "sleep"), add(loads, "tractions");
    return words + terms;
}

}  // namespace moraine
