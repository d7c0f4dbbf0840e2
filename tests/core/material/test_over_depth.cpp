#include "core/material/drive.hpp"
#include "core/material/laws.hpp"

using namespace moraine;
using namespace moraine::testing;

// A law whose strength is a scalar of the particle is the law with that number.

namespace {

using Given = std::initializer_list<std::pair<const char*, double>>;

/// Shear far beyond yield with some compression and spin, then back.
template <class C, class Law>
typename C::State sheared(const Law& law, typename C::Real strength, int scalar) {
    auto state = virgin_state<C>();
    if (scalar >= 0) state.history[scalar] = strength;
    Mat<typename C::Real, C::dim> grad = zero_mat<typename C::Real, C::dim>();
    grad(0, 0) = typename C::Real(-2e-4), grad(0, 1) = typename C::Real(5e-3);
    gradient_path<C>(law, state, grad, 1e-3, 60);
    grad(0, 0) = typename C::Real(3e-4), grad(0, 1) = typename C::Real(-7e-3);
    gradient_path<C>(law, state, grad, 1e-3, 40);
    return state;
}

template <class C, class Law, class Over>
void compare(const char* key, double strength, double tolerance,
             const std::vector<std::pair<const char*, double>>& rest) {
    const auto values = [&](double of_key) {
        std::vector<double> all;
        for (const Parameter& p : find_law(Law::name)->parameters) {
            double value = p.key == std::string(key) ? of_key : p.standard;
            for (const auto& [name, given] : rest)
                if (p.key == std::string(name)) value = given;
            all.push_back(value);
        }
        return all;
    };
    const auto expected = sheared<C>(Law(values(strength).data()), 0, -1);
    const auto found = sheared<C>(Over(values(1).data()), typename C::Real(strength), Over::own);
    CHECK(found.history[Over::own] == typename C::Real(strength));
    CHECK(expected.history[0] > 0.1);
    if (tolerance > 0) {
        for (int k = 0; k < Sym<typename C::Real, C::dim>::size; ++k)
            CHECK(double(found.stress[k]) == near(double(expected.stress[k]), tolerance, strength));
        return;
    }
    for (int k = 0; k < Sym<typename C::Real, C::dim>::size; ++k) CHECK(found.stress[k] == expected.stress[k]);
    for (int k = 0; k < Law::history; ++k) CHECK(found.history[k] == expected.history[k]);
    CHECK(found.ln_J == expected.ln_J);
    CHECK(Over(values(1).data()).wave_modulus(found) == Law(values(strength).data()).wave_modulus(expected));
}

}  // namespace

TEST_CASE_TEMPLATE("an undrained clay with su in its state has the bits of the one with that number", C, EVERY_CASE) {
    using Real = typename C::Real;
    const std::vector<std::pair<const char*, double>> elastic = {{"young", 1e6}, {"poisson", 0.3}};
    std::vector<std::pair<const char*, double>> soft = elastic;
    soft.insert(soft.end(), {{"sensitivity", 3}, {"xi95", 0.7}, {"rate_log", 0.1}, {"rate_reference", 0.01}});
    for (const auto& rest : {elastic, soft}) {
        compare<C, VonMises<Real>, VonMisesOverDepth<Real>>("su", 2000, 0, rest);
        compare<C, Tresca<Real>, TrescaOverDepth<Real>>("su", 2000, 0, rest);
    }
}

TEST_CASE_TEMPLATE("soil with its cohesion in its state is the one with that number, in double precision to the bit", C,
                   EVERY_CASE) {
    using Real = typename C::Real;
    for (const double friction : {0.0, 25.0})
        for (const double matching : {0.0, 1.0})
            compare<C, DruckerPrager<Real>, DruckerPragerOverDepth<Real>>("cohesion", 1500,
                                                                          sizeof(Real) == 8 ? 0 : C::tolerance,
                                                                          {{"young", 1e6},
                                                                           {"poisson", 0.3},
                                                                           {"friction_angle", friction},
                                                                           {"dilation_angle", friction / 5},
                                                                           {"matching", matching}});
}

TEST_CASE("grains hang together up to their own cohesion") {
    using C = Case<double, 3>;
    const DruckerPragerOverDepth<double> law(
        values_of("drucker-prager", {{"young", 1e6}, {"poisson", 0.3}, {"friction_angle", 30}, {"cohesion", 1}})
            .data());
    for (const double cohesion : {0.0, 400.0}) {
        auto state = virgin_state<C>();
        state.history[2] = cohesion;
        strain_path<C>(law, state, plane_strain<C>(1e-3, 1e-3, 0), 1, 20);
        CHECK(invariants(state.stress).mean == near(cohesion * std::sqrt(3.0), 1e-12));
    }
}

TEST_CASE("laws over depth are found by law and parameter, and no scene names them") {
    const auto over = [](const char* law, std::size_t parameter) {
        const LawInfo* info = find_law_over_depth(*find_law(law), parameter);
        return info ? std::string(info->name) : "";
    };
    CHECK(over("von-mises", 2) == "von-mises over depth");
    CHECK(over("tresca", 2) == "tresca over depth");
    CHECK(over("drucker-prager", 4) == "drucker-prager over depth");
    CHECK(over("tresca", 0) == "");
    CHECK(over("drucker-prager", 2) == "");
    CHECK(over("mu-i", 2) == "");
    for (const std::string& name : law_names()) CHECK(name.find("over depth") == std::string::npos);
    const LawInfo& clay = *find_law("tresca over depth");
    CHECK(clay.history == 2);
    CHECK(std::string(clay.history_names[1]) == clay.parameters[2].key);
    const LawInfo& soil = *find_law("drucker-prager over depth");
    CHECK(std::string(soil.history_names[2]) == soil.parameters[4].key);
    CHECK(!clay.has_initial_state);
}
