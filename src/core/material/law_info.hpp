#pragma once
// What is known of a law whatever its struct is: keys, scalars and traits for readers and writers, and what they may
// ask of it, as pointers to functions. It is made of the struct by describe(), for the laws of the program
// (core/material/laws.cpp) and for one in a file of the user's (core/particles/law_object.hpp) alike.

#include <cstddef>
#include <iterator>
#include <span>

#include "core/material/point.hpp"

namespace moraine {

inline constexpr int max_parameters = 16;

/// Calls of a law's struct<double>. Values: the parameters, then the tail.
struct LawCalls {
    double (*wave_modulus)(const double* values, const BodyStart& start, const Vec<double, 3>& stress);
    const char* (*problem_at_start)(const double* values, const BodyStart& start, const Vec<double, 3>& stress);
    const char* (*problem)(const double* values);
};

/// What a law in a file of the user's has in place of a position in Laws.
struct LawFile {
    const char* title = nullptr;  ///< name of its struct
    const char* path = nullptr;   ///< as the scene names it
    const char* text = nullptr;
    const char* type = nullptr;  ///< its struct in kernels of devices
    /// A LawBatch<Real, Dim> (core/particles/law_batch.hpp), of the caller; bytes: of a Real.
    void* (*make_batch)(int bytes, int dimension, const double* values, double density) = nullptr;
    /// Writes the struct, as a kernel takes it, where `at` is not null. Returns its size.
    std::size_t (*write)(int bytes, const double* values, void* at) = nullptr;
};

/// A name of material.law. Values are in the order of `parameters`, and checked against them.
struct LawInfo {
    const char* name;
    std::span<const Parameter> parameters;
    int history;  ///< scalars per particle
    std::span<const char* const> history_names;
    bool uses_left_stretch;
    int position;                  ///< position in Laws; -1: a law in a file
    std::span<const double> tail;  ///< values that the name fixes: they follow the parameters
    bool has_initial_state;        ///< which is not zero and depends on stress and body
    bool is_fluid;                 ///< point.hpp
    bool flows;                    ///< point.hpp
    LawCalls calls;
    LawFile file = {};
    // Of over_depth.hpp.
    std::span<const int> over_depth = {};  ///< parameters that may be each particle's own
    const char* uniform = nullptr;         ///< the law with single numbers in place of this one's last scalars
    int masks = 0;                         ///< how many laws it is, by what varies

    bool of_file() const { return position < 0; }

    /// P-wave modulus K + 4G/3 [Pa] at the start, under a stress of these normal components [Pa].
    double wave_modulus(const double* values, const BodyStart& start = {}, const Vec<double, 3>& stress = {}) const;
    /// Whether Poisson's ratio is 0.45 and more: volume then changes by a few percent in a sound run.
    bool is_nearly_incompressible(const double* values) const;
    /// nullptr, or why there is no state at the start under this stress.
    const char* problem_at_start(const double* values, const BodyStart& start, const Vec<double, 3>& stress) const;
    /// nullptr, or what is wrong between values that are each within bounds.
    const char* problem(const double* values) const;
};

namespace detail {

inline PointState<double, 3> undeformed(const Vec<double, 3>& stress) {
    PointState<double, 3> state{};
    state.left_stretch = undeformed_stretch<double, 3>();
    for (int k = 0; k < 3; ++k) state.stress[k] = stress[k];
    return state;
}

template <class Law>
double wave_modulus_of(const double* values, const BodyStart& start, const Vec<double, 3>& stress) {
    const Law law(values);
    PointState<double, 3> state = undeformed(stress);
    begin_point(law, start, state);
    return law.wave_modulus(state);
}

template <class Law>
const char* problem_at_start_of(const double* values, const BodyStart& start, const Vec<double, 3>& stress) {
    PointState<double, 3> state = undeformed(stress);
    return begin_point(Law(values), start, state);
}

}  // namespace detail

/// The law with single numbers: what is asked before there are particles.
template <class Law>
struct UniformOf {
    using Type = Law;
};
template <class Law>
requires requires {
    typename Law::Uniform;
}
struct UniformOf<Law> {
    using Type = typename Law::Uniform;
};

template <template <class> class Law>
LawInfo describe(int position) {
    using L = Law<double>;
    using U = typename UniformOf<L>::Type;
    static_assert(L::history <= max_history && std::size(L::parameters) <= max_parameters);
    LawInfo info{L::name,
                 L::parameters,
                 L::history,
                 {},
                 L::uses_left_stretch,
                 position,
                 {},
                 HasInitialState<L, double>,
                 is_fluid<L>(),
                 flows<L>(),
                 {detail::wave_modulus_of<U>, detail::problem_at_start_of<U>, L::problem}};
    if constexpr (requires { L::over_depth; }) info.over_depth = L::over_depth;
    if constexpr (requires { typename L::Uniform; }) {
        info.uniform = L::Uniform::name, info.masks = L::masks;
    } else if constexpr (L::history > 0) {
        static_assert(std::size(L::history_names) == L::history);
        info.history_names = L::history_names;
    }
    return info;
}

}  // namespace moraine
