#pragma once
// What benchmark_stability measures: cases of S1 to S28 of the verification plan, each a function that reports one line
// per method or variant: numbers, and where there is a goal whether it is met. main.cpp has the list.

#include <fmt/format.h>

#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/data/error.hpp"
#include "verification/run.hpp"

namespace moraine {

using verification::Choice;

/// One row of the table.
struct Finding {
    std::string configuration;
    std::vector<std::pair<std::string, double>> numbers;
    std::optional<bool> pass;  ///< none: a number without a goal
    std::string why;           ///< where it fails, or what else must be said
};

using Report = std::function<void(const Finding&)>;

/// Which part of a case to run.
struct Wanted {
    std::string configurations;   ///< part of the name; empty: all
    bool few = false;             ///< S1: only the clouds whose limits are the least; S25: three of Poisson's ratios
    bool free = false;            ///< S23: light nodes are not limited
    bool defaults = false;        ///< S24: with the method that fluids take by themselves
    int first = 1, count = 1000;  ///< random scenes

    bool names(const std::string& configuration) const {
        return configuration.find(configurations) != std::string::npos;
    }
};

/// Does `work`; an error of the physics that ends it is the finding's reason.
template <class Work>
void attempt(Finding& finding, const Work& work) {
    try {
        work();
    } catch (const PhysicsError& e) {
        finding.why = e.what();
    }
}

/// One finding per story and method, if its name is wanted: what measure(finding, story, method) puts in it. All have
/// goals, so one that ends with an error fails.
template <class Stories, class Method, class Measure>
void tell(const Wanted& wanted, const Report& report, const Stories& stories, std::initializer_list<Method> methods,
          const Measure& measure) {
    for (const auto& story : stories)
        for (const Method& method : methods) {
            Finding finding{fmt::format("{}: {}", story.name, method.name), {}, false, ""};
            if (!wanted.names(finding.configuration)) continue;
            attempt(finding, [&] { measure(finding, story, method); });
            report(finding);
        }
}

struct StabilityCase {
    const char* name;
    const char* message;
    void (*run)(const Wanted&, const Report&);
};

/// All methods that a scene may choose (APIC and TPIC with linear shapes are refused), their names in full.
const std::vector<Choice>& all_methods();

void find_limits(const Wanted& wanted, const Report& report);
void find_lone_limits(const Wanted& wanted, const Report& report);
void drift_on(const Wanted& wanted, const Report& report);
void meet_contrasts(const Wanted& wanted, const Report& report);
void vary_seeds(const Wanted& wanted, const Report& report);
void pull_apart(const Wanted& wanted, const Report& report);
void push_extremes(const Wanted& wanted, const Report& report);
void rest_on_plane(const Wanted& wanted, const Report& report);
void keep_accounts(const Wanted& wanted, const Report& report);
void vary_steps(const Wanted& wanted, const Report& report);
void run_random(const Wanted& wanted, const Report& report);
void run_thin(const Wanted& wanted, const Report& report);
void run_fluids(const Wanted& wanted, const Report& report);
void run_wet(const Wanted& wanted, const Report& report);
void find_substeps(const Wanted& wanted, const Report& report);
void drift_fluids(const Wanted& wanted, const Report& report);
void find_fluid_limits(const Wanted& wanted, const Report& report);

}  // namespace moraine
