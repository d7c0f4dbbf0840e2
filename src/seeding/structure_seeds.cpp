#include "seeding/structure_seeds.hpp"

#include <algorithm>

#include "core/structures/structure_set.hpp"

namespace moraine {

namespace {

template <int Dim>
double distance_in(const StructureSet<Dim>& set, std::size_t k, const Triple& x) {
    const ContactField<Dim> f = set.field();
    return surface(f.structure[k], f.corners, image_near(f, f.structure[k], vec_of<Dim>(x))).distance;
}

}  // namespace

StructuresAtStart::StructuresAtStart(const Scene& scene) {
    if (scene.dimensions == 2)
        flat_ = std::make_unique<StructureSet<2>>(scene);
    else
        solid_ = std::make_unique<StructureSet<3>>(scene);
}

StructuresAtStart::~StructuresAtStart() = default;

double StructuresAtStart::distance(std::size_t k, const Triple& x) const {
    return flat_ ? distance_in(*flat_, k, x) : distance_in(*solid_, k, x);
}

void clear_structures(const Scene& scene, std::vector<Seed>& seeds) {
    std::vector<std::size_t> clearing;
    for (std::size_t k = 0; k < scene.structures.size(); ++k)
        if (scene.structures[k].clear) clearing.push_back(k);
    if (clearing.empty()) return;
    const StructuresAtStart structures(scene);
    std::erase_if(seeds, [&](const Seed& s) {
        return std::any_of(clearing.begin(), clearing.end(),
                           [&](std::size_t k) { return structures.distance(k, s.x) < 0; });
    });
}

}  // namespace moraine
