// S27: the largest stable step dt c / h of a fluid without viscosity with each cure, by bisection, as in S1 and in its
// clouds that decide and in the full square. Light nodes are not limited, but the cells of
// pressures on the grid are always. Substeps are in S25.

#include <fmt/format.h>

#include <algorithm>

#include "core/courant.hpp"
#include "stability/bisect.hpp"
#include "stability/cases.hpp"
#include "stability/cures.hpp"
#include "verification/problem_cloud.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double nu = 0.495;
constexpr Cloud clouds[] = {
    {"strip adrift", 2, true, false, 0.05},
    {"2-D adrift", 2, false, false, 0.05},
    {"2-D free", 2, false, true, 0.05},
    {"3-D free", 3, false, true, 0.05},
};

bool is_stable(const Cloud& cloud, const Choice& method, const Cure& cure, double courant) {
    Scene scene = cloud_scene(cloud, method, courant);
    const double young = (1 + nu) * (1 - 2 * nu) / (1 - nu);
    scene.materials = {material("newtonian", 1, {{"young", young}, {"poisson", nu}, {"viscosity", 0}})};
    cure_fluid(scene, cure);
    return cloud_is_stable(cloud, scene);
}

}  // namespace

void find_fluid_limits(const Wanted& wanted, const Report& report) {
    for (const Cure& cure : cures)
        for (const Choice& method : cured_methods) {
            Finding finding{fmt::format("{}, {}", method.name, cure.name), {}, true, ""};
            if (cure.substeps > 1 || !wanted.names(finding.configuration)) continue;
            double guess = 1, least = most_courant;
            for (const Cloud& cloud : clouds) {
                const double limit =
                    largest_stable([&](double courant) { return is_stable(cloud, method, cure, courant); }, guess);
                guess = std::clamp(limit, 0.1, 2.0);
                least = std::min(least, limit);
                finding.numbers.emplace_back(cloud.name, limit);
            }
            finding.numbers.emplace_back("least", least);
            const double asked = 0.8 * stable_courant(method.shape, method.transfer, method.update);
            finding.numbers.emplace_back("default", asked);
            if (least < asked) finding.pass = false, finding.why = "below the default";
            report(finding);
        }
}

}  // namespace moraine
