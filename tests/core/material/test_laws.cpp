#include <cmath>
#include <set>

#include "core/material/drive.hpp"
#include "core/material/laws.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {

/// Values well inside every bound; required ones get a number of the right size.
std::vector<double> typical(const LawInfo& info) {
    std::vector<double> values;
    for (const Parameter& p : info.parameters) {
        const std::string key = p.key;
        double v = std::isnan(p.standard) ? 30 : p.standard;
        if (key == "young") v = 1e6;
        if (key == "poisson") v = 0.3;
        if (key == "static_friction") v = 0.38;
        if (key == "limit_friction") v = 0.64;
        if (key == "sensitivity") v = 2;
        if (key == "rate_reference") v = 0.1;
        if (key == "compression_index") v = 0.2;
        if (key == "swelling_index") v = 0.04;
        if (key == "critical_state_ratio" || key == "reference_void_ratio") v = 1;
        values.push_back(v);
    }
    return values;
}

/// A number that depends on everything a law can do: shear far beyond yield under pressure.
double fingerprint(const LawInfo& info, const std::vector<double>& values) {
    return with_law<double>(info, values.data(), [](const auto& law) {
        using C = Case<double, 3>;
        auto state = virgin_state<C>();
        begin_point(law, {}, state);
        Mat<double, 3> grad = zero_mat<double, 3>();
        grad(0, 0) = -2e-4, grad(0, 1) = 5e-3, grad(2, 2) = -1e-4;
        gradient_path<C>(law, state, grad, 1e-3, 100);
        double sum = law.strain_energy(state) + 1e-3 * law.wave_modulus(state);
        for (int k = 0; k < 6; ++k) sum += (k + 1) * std::fabs(state.stress[k]);
        return sum;
    });
}

}  // namespace

TEST_CASE("the list holds every law by its name, and no other") {
    const std::vector<std::string> expected = {"linear-elastic",   "neo-hookean",    "von-mises", "tresca",
                                               "herschel-bulkley", "drucker-prager", "mu-i",      "modified-cam-clay",
                                               "bingham",          "newtonian"};
    CHECK(law_names() == expected);
    for (const std::string& name : law_names()) CHECK(find_law(name)->name == name);
    for (const char* name : {"", "von_mises", "Tresca", "tresca ", "mohr-coulomb"}) CHECK(find_law(name) == nullptr);
}

TEST_CASE("tables are complete: each key once, defaults within bounds, a unit and a meaning") {
    for (const std::string& name : law_names()) {
        CAPTURE(name);
        const LawInfo& info = *find_law(name);
        std::set<std::string> keys;
        for (const Parameter& p : info.parameters) {
            CAPTURE(p.key);
            CHECK(keys.insert(p.key).second);
            CHECK(p.lower < p.upper);
            if (!std::isnan(p.standard)) {
                CHECK(p.standard >= p.lower);
                CHECK(p.standard <= p.upper);
                if (p.open) CHECK((p.standard != p.lower && p.standard != p.upper));
            }
            CHECK(std::string(p.unit).size() > 0);
            CHECK(std::string(p.meaning).size() > 5);
        }
        CHECK(int(info.history_names.size()) == info.history);
        CHECK(info.problem(typical(info).data()) == nullptr);
    }
}

TEST_CASE("every parameter of a table changes what the law does") {
    for (const std::string& name : law_names()) {
        const LawInfo& info = *find_law(name);
        for (std::size_t i = 0; i < info.parameters.size(); ++i) {
            CAPTURE(name);
            CAPTURE(info.parameters[i].key);
            std::vector<double> values = typical(info);
            const std::string key = info.parameters[i].key;
            if (key.starts_with("rate_")) values[3] = 0.1;  // on, to see the reference
            if (key == "rate_exponent" || key == "rate_power") values[3] = 0, values[5] = 0.1;
            std::vector<double> other = values;
            other[i] = key == "matching" ? 1 : (values[i] == 0 ? 0.2 : values[i] * 1.2);
            if (key == "cohesion") other[i] = 100;
            CHECK(fingerprint(info, values) != doctest::Approx(fingerprint(info, other)).epsilon(1e-7));
        }
    }
}

TEST_CASE("the wave modulus of a virgin law is K + 4G/3, whatever its name") {
    for (const std::string& name : law_names()) {
        CAPTURE(name);
        const LawInfo& info = *find_law(name);
        // Cam clay: v floor / kappa at the start, e by its 1 kPa, which the floor is
        const double bulk = name == "modified-cam-clay" ? 2 * 1000 / 0.04 : 1e6 / (3 * 0.4);
        CHECK(info.wave_modulus(typical(info).data()) == near(bulk * (1 + 2 * 0.4 / 1.3), 1e-14));
    }
}

TEST_CASE("a kernel is compiled once per struct, and gets it in its precision") {
    const std::vector<double> values = typical(*find_law("bingham"));
    const bool right = with_law<float>("bingham", values.data(), [](const auto& law) {
        return std::is_same_v<std::decay_t<decltype(law)>, HerschelBulkley<float>>;
    });
    CHECK(right);
    CHECK(find_law("bingham")->position == find_law("herschel-bulkley")->position);
    CHECK(find_law("neo-hookean")->uses_left_stretch);
    CHECK(!find_law("tresca")->uses_left_stretch);
}
