#include "core/material/drive.hpp"
#include "core/material/laws.hpp"
#include "core/particles/stress.hpp"

using namespace moraine;
using namespace moraine::testing;

// A law whose strength is a scalar of the particle is the law with that number.

namespace {

using Given = std::vector<std::pair<const char*, double>>;

/// The values of a law's struct, with the given ones in place of the defaults; then the mask, where it has one.
std::vector<double> values_with(const char* law, const Given& given, int mask = -1) {
    std::vector<double> all;
    for (const Parameter& p : find_law(law)->parameters) {
        all.push_back(p.standard);
        for (const auto& [name, value] : given)
            if (p.key == std::string(name)) all.back() = value;
    }
    if (mask >= 0) all.push_back(mask);
    return all;
}

/// Shear far beyond yield with some compression and spin, then back. own: the particle's scalars behind those of `law`.
template <class C, class Law>
typename C::State sheared(const Law& law, const std::vector<double>& own = {}, int first = 0) {
    auto state = virgin_state<C>();
    for (std::size_t k = 0; k < own.size(); ++k) state.history[first + static_cast<int>(k)] = typename C::Real(own[k]);
    Mat<typename C::Real, C::dim> grad = zero_mat<typename C::Real, C::dim>();
    grad(0, 0) = typename C::Real(-2e-4), grad(0, 1) = typename C::Real(5e-3);
    gradient_path<C>(law, state, grad, 1e-3, 60);
    grad(0, 0) = typename C::Real(3e-4), grad(0, 1) = typename C::Real(-7e-3);
    gradient_path<C>(law, state, grad, 1e-3, 40);
    return state;
}

/// Law with all numbers of `given`, beside the one that has those of `own` from its particle and others as its own
/// numbers. tolerance 0: to the bit.
template <class C, class Law, class Over>
void compare(Given given, const Given& own, double tolerance) {
    std::vector<double> scalars;
    Given others = given;
    int mask = 0;
    for (const auto& [key, value] : own) {
        int bit = 0;
        for (std::size_t k = 0; k < std::size(Law::over_depth); ++k)
            if (std::string(Law::parameters[Law::over_depth[k]].key) == key) bit = 1 << k;
        REQUIRE(bit > mask);
        mask |= bit;
        scalars.push_back(value);
        given.emplace_back(key, value), others.emplace_back(key, 1);
    }
    const Law one(values_with(Law::name, given).data());
    const Over over(values_with(Law::name, others, mask).data());
    CHECK(over.scalars() == Over::own + static_cast<int>(own.size()));
    const auto expected = sheared<C>(one), found = sheared<C>(over, scalars, Over::own);
    for (std::size_t k = 0; k < own.size(); ++k)
        CHECK(found.history[Over::own + static_cast<int>(k)] == typename C::Real(scalars[k]));
    const double unit = std::sqrt(double(contract(expected.stress, expected.stress)));
    CHECK(unit > 0);
    for (int k = 0; k < Sym<typename C::Real, C::dim>::size; ++k) {
        if (tolerance > 0)
            CHECK(double(found.stress[k]) == near(double(expected.stress[k]), tolerance, unit));
        else
            CHECK(found.stress[k] == expected.stress[k]);
    }
    for (int k = 0; tolerance == 0 && k < Law::history; ++k) CHECK(found.history[k] == expected.history[k]);
    CHECK(double(over.wave_modulus(found)) == near(double(one.wave_modulus(expected)), C::tolerance));
    CHECK(double(over.strain_energy(found)) == near(double(one.strain_energy(expected)), 100 * C::tolerance));
}

}  // namespace

TEST_CASE_TEMPLATE("an undrained clay with su in its state has the bits of the one with that number", C, EVERY_CASE) {
    using Real = typename C::Real;
    const Given elastic = {{"young", 1e6}, {"poisson", 0.3}};
    Given soft = elastic;
    soft.insert(soft.end(), {{"sensitivity", 3}, {"xi95", 0.7}, {"rate_log", 0.1}, {"rate_reference", 0.01}});
    for (const auto& rest : {elastic, soft}) {
        compare<C, VonMises<Real>, VonMisesOverDepth<Real>>(rest, {{"su", 2000}}, 0);
        compare<C, Tresca<Real>, TrescaOverDepth<Real>>(rest, {{"su", 2000}}, 0);
    }
}

TEST_CASE_TEMPLATE("soil with its friction and cohesion in its state is the one with those numbers", C, EVERY_CASE) {
    using Real = typename C::Real;
    for (const double friction : {2.0, 25.0})
        for (const double matching : {0.0, 1.0}) {
            const Given rest = {{"young", 1e6},
                                {"poisson", 0.3},
                                {"friction_angle", friction},
                                {"dilation_angle", friction / 5},
                                {"cohesion", 1500},
                                {"matching", matching}};
            const double bits = sizeof(Real) == 8 ? 0 : C::tolerance;
            compare<C, DruckerPrager<Real>, DruckerPragerOverDepth<Real>>(rest, {{"cohesion", 1500}}, bits);
            compare<C, DruckerPrager<Real>, DruckerPragerOverDepth<Real>>(rest, {{"friction_angle", friction}},
                                                                          C::tolerance);
            compare<C, DruckerPrager<Real>, DruckerPragerOverDepth<Real>>(
                rest, {{"friction_angle", friction}, {"cohesion", 1500}}, C::tolerance);
        }
}

TEST_CASE_TEMPLATE("a stiffness in its state is that number, of every law that takes one, beside strengths", C,
                   EVERY_CASE) {
    using Real = typename C::Real;
    const Given stiff = {{"young", 3e5}};
    const double tolerance = 100 * C::tolerance;
    compare<C, LinearElastic<Real>, LinearElasticOverDepth<Real>>({{"poisson", 0.3}}, stiff, tolerance);
    compare<C, NeoHookean<Real>, NeoHookeanOverDepth<Real>>({{"poisson", 0.3}}, stiff, tolerance);
    const Given clay = {{"poisson", 0.3}, {"su", 2000}};
    compare<C, VonMises<Real>, VonMisesOverDepth<Real>>(clay, stiff, tolerance);
    compare<C, Tresca<Real>, TrescaOverDepth<Real>>(clay, {{"young", 3e5}, {"su", 1500}}, tolerance);
    compare<C, DruckerPrager<Real>, DruckerPragerOverDepth<Real>>(
        {{"poisson", 0.3}}, {{"young", 3e5}, {"friction_angle", 20}, {"cohesion", 400}}, tolerance);
}

TEST_CASE("grains hang together up to their own cohesion") {
    using C = Case<double, 3>;
    const DruckerPragerOverDepth<double> law(
        values_with("drucker-prager", {{"young", 1e6}, {"poisson", 0.3}, {"friction_angle", 30}, {"cohesion", 1}}, 4)
            .data());
    for (const double cohesion : {0.0, 400.0}) {
        auto state = virgin_state<C>();
        state.history[2] = cohesion;
        strain_path<C>(law, state, plane_strain<C>(1e-3, 1e-3, 0), 1, 20);
        CHECK(invariants(state.stress).mean == near(cohesion * std::sqrt(3.0), 1e-12));
    }
}

TEST_CASE("a clay keeps its strength as it is now, with its rate effect and softening") {
    using C = Case<double, 3>;
    const Given soft = {{"young", 1e6},    {"poisson", 0.3},        {"su", 2000}, {"sensitivity", 3}, {"xi95", 0.7},
                        {"rate_log", 0.1}, {"rate_reference", 0.01}};
    constexpr int strength_alone = 1 << TrescaOverDepth<double>::strength_now;
    const auto check = [&](const auto& law) {
        const auto state = sheared<C>(law, {2000}, 1);
        const double rate = 1 + 0.1 * std::log10(7.0 / 0.01);  // about: the shear rate is 7 1/s
        const auto left = [](double xi) { return 2000 * (1.0 / 3 + 2.0 / 3 * std::exp(-3 * xi / 0.7)); };
        CHECK(state.history[0] > 0.1);
        CHECK(state.history[1] == near(rate * left(state.history[0]), 2e-3));
        auto still = state;
        gradient_path<C>(law, still, zero_mat<double, 3>(), 1e-3, 1);
        CHECK(still.history[1] == near(left(still.history[0]), 1e-12));
    };
    check(TrescaOverDepth<double>(values_with("tresca", soft, strength_alone).data()));
    check(VonMisesOverDepth<double>(values_with("von-mises", soft, strength_alone).data()));
}

TEST_CASE("laws over depth are found by law and properties, and no scene names them") {
    const auto over = [](const char* law, const OwnScalars& own) {
        const LawInfo* info = find_law_over_depth(*find_law(law), own);
        return info ? std::string(info->name) : "";
    };
    CHECK(over("von-mises", {{2}}) == "von-mises over depth (su)");
    CHECK(over("tresca", {{2, 0}}) == "tresca over depth (young, su)");
    CHECK(over("tresca", {{9}, true}) == "tresca over depth (initial_density, strength)");
    CHECK(over("drucker-prager", {{4, 2, 0, 6}}) ==
          "drucker-prager over depth (young, friction_angle, cohesion, initial_density)");
    CHECK(over("linear-elastic", {{2}}) == "linear-elastic over depth (initial_density)");
    CHECK(over("tresca", {{1}}) == "");
    CHECK(over("drucker-prager", {{4}, true}) == "");
    CHECK(over("mu-i", {{2}}) == "");
    for (const std::string& name : law_names()) CHECK(name.find("over depth") == std::string::npos);
    const LawInfo& clay = *find_law_over_depth(*find_law("tresca"), {{2, 9}});
    CHECK(clay.history == 3);
    CHECK(scalar_named(clay, "su") == 1);
    CHECK(scalar_named(clay, "density") == 2);
    CHECK(scalar_named(clay, "young") == -1);
    const LawInfo& soil = *find_law_over_depth(*find_law("drucker-prager"), {{4}});
    CHECK(std::string(soil.history_names[2]) == "cohesion");
    CHECK(!clay.has_initial_state);
}
