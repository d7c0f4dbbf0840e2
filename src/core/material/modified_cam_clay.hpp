#pragma once
// Modified Cam Clay: Roscoe and Burland (1968), with the void ratio e as a state and elastic moduli from kappa.
//
//   p = -tr sigma / 3 (compression positive),  q = sqrt(3 J2),  v = 1 + e,   x* = max(x, floor)
//   f = q^2 / M^2 + p (p - p_c*) <= 0,   associated flow:  de_p = L (2p - p_c*) (compression),  dg_p = 3 L s / M^2
//   elastic: kappa d(ln p) = -de_e,  K = v p* / kappa,  G = 3 K (1 - 2 nu) / (2 (1 + nu)); below the floor K is
//   constant hardening: (lambda - kappa) d(ln p_c) = v de_p;      dv = v d(ln J)
//
// Start: p_c = OCR times that of the yield surface through the stress; e = e_1 - lambda ln(p_c / 1 kPa) + kappa ln(p_c
// / p).
//
// Volumes are integrated exactly (ln p and ln p_c against e), the direction of flow by the midpoint rule (Ortiz and
// Popov 1985, doi 10.1002/nme.1620210902), of second order: 1e-6 in 1e4 increments, where backward Euler has 1e-4. A
// step that begins inside the surface, or goes far beyond it, is a backward Euler step; one of more than 0.5 % strain
// is done in parts. Two unknowns, by Newton's method: y, the plastic compression, and a = 3 G L / M^2.
//
// The floor is for the free surface: p* keeps a stiffness and p_c* an elastic range there. Soil pulled apart flows at
// p = 0, its p_c falls without bound (as a logarithm), and its volume must close again before it bears: no tension.

#include <cmath>

#include "core/material/hypoelastic.hpp"

namespace moraine {

template <class Real>
struct ModifiedCamClay {
    static constexpr const char* name = "modified-cam-clay";
    static constexpr int history = 3;
    static constexpr const char* history_names[] = {"preconsolidation_pressure", "void_ratio", "plastic_shear_strain"};
    static constexpr bool uses_left_stretch = false;
    static constexpr DeviceBlocks device_blocks{
        .plain = 4, .averaged = 3, .affine = 3, .affine_averaged = 3, .split = 4, .double_fused = 2, .double_split = 2};
    static constexpr Parameter parameters[] = {
        {"compression_index", "-", required, 0, unbounded, true, "Lambda: slope of e over ln p, virgin compression"},
        {"swelling_index", "-", required, 0, unbounded, true, "Kappa: slope of e over ln p, unloading"},
        {"critical_state_ratio", "-", required, 0, unbounded, true, "M: q / p at the critical state"},
        {"poisson", "-", required, -1, 0.5, true, "Poisson's ratio"},
        {"reference_void_ratio", "-", required, 0, unbounded, true,
         "void ratio of virgin isotropic compression at 1 kPa"},
        {"pressure_floor", "Pa", 1000, 0, unbounded, true, "least mean pressure of moduli and yield surface"}};

    Real lambda, kappa;  ///< of ln p [-]
    Real slope2;         ///< M^2 [-]
    Real shear;          ///< G / K [-]
    Real reference;      ///< e at 1 kPa [-]
    Real floor;          ///< [Pa]

    explicit ModifiedCamClay(const double* values)
        : lambda(Real(values[0])),
          kappa(Real(values[1])),
          slope2(Real(values[2] * values[2])),
          shear(Real(1.5 * (1 - 2 * values[3]) / (1 + values[3]))),
          reference(Real(values[4])),
          floor(Real(values[5])) {}

    static const char* problem(const double* values) {
        if (values[1] >= values[0])
            return "swelling_index is not below compression_index (nothing would yield). Exchange them?";
        return nullptr;
    }

    /// Preconsolidation pressure and void ratio under the initial stress.
    template <int Dim>
    const char* begin(const BodyStart& start, PointState<Real, Dim>& state) const {
        using std::log;
        const Invariants<Real> v = invariants(state.stress);
        const Real p = -v.mean > floor ? -v.mean : floor;
        const Real yield = Real(start.over_consolidation_ratio) * (p + Real(3) * v.j2 / (slope2 * p));
        state.history[0] = yield;
        state.history[1] = reference - lambda * log(yield / Real(1000)) + kappa * log(yield / p);
        state.history[2] = Real(0);
        if (!(state.history[1] > Real(0)))
            return "the void ratio at the start is not above 0 (by compression_index and reference_void_ratio at that "
                   "depth). A larger reference_void_ratio?";
        return nullptr;
    }

    template <int Dim>
    MORAINE_HD void update(const StrainIncrement<Real, Dim>& step, PointState<Real, Dim>& state) const {
        using std::sqrt;
        state.stress = rotated(state.stress, step.rotation);
        Real square = Real(0);
        for (int k = 0; k < Sym<Real, Dim>::size; ++k) square += step.strain[k] * step.strain[k];
        const Real parts = sqrt(square) / longest;
        const int count = parts < Real(most_parts) ? 1 + static_cast<int>(parts) : most_parts;
        for (int n = 0; n < count; ++n) advance(step, Real(1) / Real(count), state);
    }

    template <int Dim>
    MORAINE_HD Real wave_modulus(const PointState<Real, Dim>& state) const {
        return (Real(1) + shear * Real(4.0 / 3.0)) * bulk(-state.stress.trace() * Real(1.0 / 3.0), state);
    }

    template <int Dim>
    MORAINE_HD Real strain_energy(const PointState<Real, Dim>& state) const {
        const Invariants<Real> v = invariants(state.stress);
        const Real p = -v.mean, stored = p > floor ? p - Real(0.5) * floor : Real(0.5) * p * p / floor;
        return stored * kappa / (Real(1) + state.history[1]) + Real(0.5) * v.j2 / (shear * bulk(p, state));
    }

  private:
    static constexpr Real tolerance =
        sizeof(Real) == 8 ? Real(1e-9) : Real(1e-5);  ///< of a correction; the next is its square
    static constexpr int most_iterations = 30;
    static constexpr Real longest = Real(5e-3);  ///< strain of a step that is one part
    static constexpr int most_parts = 64;

    /// What a step begins with.
    template <int Dim>
    struct Step {
        Sym<Real, Dim> stress, strain;  ///< deviators: in the axes of the end, of the increment
        Real pressure, yield;           ///< p and p_c [Pa]
        Real volume;                    ///< v in mid-step
        Real compression;               ///< -de
        Real ss = 0, se = 0, ee = 0;    ///< s:s, s:de, de:de
    };

    /// A trial of the step's end, by y and a.
    struct Trial {
        Real y, a;
        Real p, yield;      ///< p and p_c* [Pa]
        Real q2, G, f, r;   ///< q^2, shear modulus, and what is to vanish: f, and 3 G y - a M^2 (2p - p_c)
        Real dp, dyield;    ///< by y
        Real dq2_a, dq2_y;  ///< of q^2
        Real dG;            ///< by y
        Real flow;          ///< 2p - p_c at the place of the flow's direction
    };

    MORAINE_HD Real at_least(Real p) const { return p > floor ? p : floor; }

    template <int Dim>
    MORAINE_HD Real bulk(Real p, const PointState<Real, Dim>& state) const {
        return (Real(1) + state.history[1]) * at_least(p) / kappa;
    }

    /// Where the pressure p comes when -e_elastic / kappa grows by d: p exp(d) above the floor, p + floor d below.
    MORAINE_HD Real moved(Real p, Real d) const {
        using std::exp;
        using std::log;
        if (p >= floor) {
            const Real to = p * exp(d);
            return to >= floor ? to : floor * (Real(1) + d - log(floor / p));
        }
        const Real to = p + floor * d;
        return to <= floor ? to : floor * exp(d - (Real(1) - p / floor));
    }

    /// theta: of the step, where the direction of flow is taken.
    template <int Dim>
    MORAINE_HD Trial trial(const Step<Dim>& s, Real theta, Real y, Real a) const {
        using std::exp;
        Trial t;
        t.y = y, t.a = a;
        t.p = moved(s.pressure, (s.compression - s.volume * y) / kappa);
        t.dp = -at_least(t.p) * s.volume / kappa;
        const Real yield = s.yield * exp(s.volume * y / (lambda - kappa));
        t.yield = at_least(yield);
        t.dyield = yield > floor ? yield * s.volume / (lambda - kappa) : Real(0);
        const Real to_shear = shear * s.volume / kappa * Real(0.5);
        t.G = to_shear * (at_least(s.pressure) + at_least(t.p));
        t.dG = t.p > floor ? to_shear * t.dp : Real(0);

        // s = (c s_n + 2 G de) / b
        const Real c = Real(1) - Real(2) * a * (Real(1) - theta), b = Real(1) + Real(2) * a * theta;
        const Real dc = Real(-2) * (Real(1) - theta), db = Real(2) * theta;
        const Real square = c * c * s.ss + Real(4) * t.G * (c * s.se + t.G * s.ee);
        const Real scale = Real(1.5) / (b * b);
        t.q2 = scale * square;
        t.dq2_a = scale * (dc * (Real(2) * c * s.ss + Real(4) * t.G * s.se) - Real(2) * square * db / b);
        t.dq2_y = scale * t.dG * (Real(4) * c * s.se + Real(8) * t.G * s.ee);

        t.f = t.q2 / slope2 + t.p * (t.p - t.yield);
        t.flow = (Real(1) - theta) * (Real(2) * s.pressure - at_least(s.yield)) + theta * (Real(2) * t.p - t.yield);
        t.r = Real(3) * t.G * y - a * slope2 * t.flow;
        return t;
    }

    /// Solves f = r = 0 from y = a = 0; false: it did not converge.
    template <int Dim>
    MORAINE_HD bool solve(const Step<Dim>& s, Real theta, Trial& t) const {
        using std::fabs;
        t = trial(s, theta, Real(0), Real(0));
        const Real reach = kappa / s.volume;  // of y: p changes by e
        for (int n = 0; n < most_iterations; ++n) {
            const Real fy = t.dq2_y / slope2 + (Real(2) * t.p - t.yield) * t.dp - t.p * t.dyield, fa = t.dq2_a / slope2;
            const Real ry = Real(3) * (t.G + t.dG * t.y) - t.a * slope2 * theta * (Real(2) * t.dp - t.dyield);
            const Real ra = -slope2 * t.flow;
            const Real determinant = fy * ra - fa * ry;
            if (!(fabs(determinant) > Real(0))) return false;
            Real dy = (fa * t.r - ra * t.f) / determinant, da = (ry * t.f - fy * t.r) / determinant;
            const Real far = fabs(dy) / reach;
            if (far > Real(1)) dy /= far, da /= far;
            if (t.a + da < Real(0)) da = -t.a;
            t = trial(s, theta, t.y + dy, t.a + da);
            if (fabs(dy) <= tolerance * reach && fabs(da) <= tolerance * (Real(1) + t.a)) return is_on_surface(t);
        }
        return false;
    }

    /// Corrections vanish there, and where a number overflows.
    MORAINE_HD bool is_on_surface(const Trial& t) const {
        using std::fabs;
        return fabs(t.f) <= Real(10) * tolerance * (t.p * t.p + t.yield * t.yield);
    }

    /// A part of a step, in the axes of its end.
    template <int Dim>
    MORAINE_HD void advance(const StrainIncrement<Real, Dim>& step, Real part, PointState<Real, Dim>& state) const {
        using std::expm1;
        Step<Dim> s;
        s.stress = state.stress;
        const Real mean = s.stress.trace() * Real(1.0 / 3.0), third = step.strain.trace() * part * Real(1.0 / 3.0);
        s.pressure = -mean;
        s.yield = state.history[0];
        for (int k = 0; k < Sym<Real, Dim>::size; ++k) s.strain[k] = step.strain[k] * part;
        for (int k = 0; k < 3; ++k) s.stress[k] -= mean, s.strain[k] -= third;
        const Real volume = Real(1) + state.history[1], change = volume * expm1(step.volumetric * part);
        state.history[1] += change;
        s.volume = volume + Real(0.5) * change;
        s.compression = -change;
        for (int k = 0; k < Sym<Real, Dim>::size; ++k) {
            const Real twice = k < 3 ? Real(1) : Real(2);
            s.ss += twice * s.stress[k] * s.stress[k];
            s.se += twice * s.stress[k] * s.strain[k];
            s.ee += twice * s.strain[k] * s.strain[k];
        }
        finish(s, state);
    }

    template <int Dim>
    MORAINE_HD void finish(const Step<Dim>& s, PointState<Real, Dim>& state) const {
        using std::sqrt;
        Real theta = Real(1);
        Trial t = trial(s, theta, Real(0), Real(0));
        if (t.f > Real(0)) {
            const Real size = at_least(s.yield) * at_least(s.yield);
            const Real before = Real(1.5) * s.ss / slope2 + s.pressure * (s.pressure - at_least(s.yield));
            const bool follows = before > Real(-1e-3) * size && t.f < Real(0.1) * size;
            if (follows) theta = Real(0.5);
            if (!solve(s, theta, t) && !(follows && solve(s, theta = Real(1), t))) return to_surface(s, state);
        }
        const Real c = Real(1) - Real(2) * t.a * (Real(1) - theta), b = Real(1) + Real(2) * t.a * theta;
        Real flow2 = Real(0);  // s_m : s_m
        for (int k = 0; k < Sym<Real, Dim>::size; ++k) {
            const Real end = (c * s.stress[k] + Real(2) * t.G * s.strain[k]) / b;
            const Real middle = (Real(1) - theta) * s.stress[k] + theta * end;
            flow2 += (k < 3 ? Real(1) : Real(2)) * middle * middle;
            state.stress[k] = end - (k < 3 ? t.p : Real(0));
        }
        harden(s, t.y, state);
        state.history[2] += t.a / t.G * sqrt(Real(2) * flow2);
    }

    /// p_c of the end; it stays above what single precision can tell from 0.
    template <int Dim>
    MORAINE_HD void harden(const Step<Dim>& s, Real y, PointState<Real, Dim>& state) const {
        using std::exp;
        const Real yield = s.yield * exp(s.volume * y / (lambda - kappa)), least = floor * Real(1e-30);
        state.history[0] = yield > least ? yield : least;
    }

    /// Where no solution was found (strains of several per cent in each of many steps): the elastic trial, its deviator
    /// put back to the surface.
    template <int Dim>
    MORAINE_HD void to_surface(const Step<Dim>& s, PointState<Real, Dim>& state) const {
        using std::sqrt;
        const Trial t = trial(s, Real(1), Real(0), Real(0));
        const Real p = t.p < Real(0) ? Real(0) : (t.p > t.yield ? t.yield : t.p);
        const Real most = slope2 * p * (t.yield - p), factor = t.q2 > most ? sqrt(most / t.q2) : Real(1);
        for (int k = 0; k < Sym<Real, Dim>::size; ++k)
            state.stress[k] = factor * (s.stress[k] + Real(2) * t.G * s.strain[k]) - (k < 3 ? p : Real(0));
    }
};

}  // namespace moraine
