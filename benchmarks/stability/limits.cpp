// S1: the largest stable step dt c / h of every method, by bisection.

#include <algorithm>

#include "stability/bisect.hpp"
#include "stability/cases.hpp"
#include "verification/problem_cloud.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr Cloud clouds[] = {
    {"strip frozen", 2, true, false, 0},          {"strip adrift", 2, true, false, 0.05},
    {"strip free", 2, true, true, 0.05},          {"2-D frozen", 2, false, false, 0},
    {"2-D adrift", 2, false, false, 0.05},        {"2-D free", 2, false, true, 0.05},
    {"2-D jittered", 2, false, true, 0.05, 0.25}, {"3-D adrift", 3, false, false, 0.05},
    {"3-D free", 3, false, true, 0.05},
};

/// Some of these have the least limit in every method that was measured in full.
bool governs(const Cloud& cloud) {
    const std::string name = cloud.name;
    return name == "strip adrift" || name == "2-D free" || name == "3-D free";
}

}  // namespace

void find_limits(const Wanted& wanted, const Report& report) {
    for (const Choice& choice : all_methods()) {
        if (!wanted.names(choice.name)) continue;
        Finding finding{choice.name, {}, {}, ""};
        double guess = 1, all = most_courant;
        for (const Cloud& cloud : clouds) {
            if (wanted.few && !governs(cloud)) continue;
            const double limit =
                largest_stable([&](double courant) { return cloud_is_stable(cloud, choice, courant); }, guess);
            guess = std::clamp(limit, 0.1, 2.0);
            if (cloud.mach > 0) all = std::min(all, limit);
            finding.numbers.emplace_back(cloud.name, limit);
        }
        finding.numbers.emplace_back("least adrift", all);
        report(finding);
    }
}

}  // namespace moraine
