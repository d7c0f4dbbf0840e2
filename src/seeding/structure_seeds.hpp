#pragma once
// Particles and structures at the start: no particle may begin inside a structure. One that does is removed where the
// structure says so (clear = true); else the scene is refused (scene_check_structures.cpp).

#include <memory>
#include <vector>

#include "core/scene_spec.hpp"
#include "seeding/seed.hpp"

namespace moraine {

template <int Dim>
class StructureSet;

/// Takes the seeds away that are inside a structure with `clear`.
void clear_structures(const Scene& scene, std::vector<Seed>& seeds);

/// Signed distances of all structures of a scene at the start.
class StructuresAtStart {
  public:
    explicit StructuresAtStart(const Scene& scene);
    ~StructuresAtStart();
    /// Of structure k at x [m]; negative inside.
    double distance(std::size_t k, const Triple& x) const;

  private:
    std::unique_ptr<StructureSet<2>> flat_;
    std::unique_ptr<StructureSet<3>> solid_;
};

}  // namespace moraine
