#pragma once
// Particles as columns: one array per quantity, and only those that the scene's transfer, shape and
// materials name. A particle lives in a slot until the memory is refreshed; lists of slots move
// every step, particles do not (core/binning.hpp).

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/material/point.hpp"
#include "core/position.hpp"
#include "core/vec.hpp"

namespace moraine {

/// Pointers to the columns; null: the scene has no such column.
template <class Real, int Dim>
struct ParticleView {
    std::uint64_t* id;
    std::uint16_t* body;
    Vec<Coordinate<Real>, Dim>* position;  ///< in the block, fixed point [cells]
    Vec<Real, Dim>* velocity;              ///< [m/s]
    Real* mass;                            ///< [kg]
    Real* volume;                          ///< V0 J [m3]
    Real* ln_J;                            ///< logarithm of the volume ratio [-]
    Sym<Real, Dim>* stress;                ///< Cauchy, tension positive [Pa]
    Mat<Real, Dim>* affine;                ///< C of APIC or TPIC [1/s]
    Sym<Real, Dim>* left_stretch;          ///< b - I, b = F Fᵀ [-]
    Vec<Real, Dim>* log_stretch;           ///< of a contiguous GIMP box, per axis [-]
    Real* history[max_history];            ///< scalars of the material
    Vec<Real, Dim>* body_force;            ///< manufactured acceleration of this step [m/s2]

    /// Asks the cache for what P2G reads of slot s. Lists follow memory only while it is fresh: with 5 % of the
    /// particles out of place a step took 1.4 times as long without this.
    MORAINE_HD void fetch(std::uint32_t s) const {
#if defined(__GNUC__) && !defined(__CUDACC__)
        __builtin_prefetch(position + s);
        __builtin_prefetch(velocity + s);
        __builtin_prefetch(mass + s);
        __builtin_prefetch(volume + s);
        __builtin_prefetch(stress + s);
        if (affine) __builtin_prefetch(affine + s);
#endif
    }

    /// And what the gather and the stress update read besides.
    MORAINE_HD void fetch_all(std::uint32_t s) const {
        fetch(s);
#if defined(__GNUC__) && !defined(__CUDACC__)
        __builtin_prefetch(ln_J + s);
        for (int k = 0; k < max_history; ++k)
            if (history[k]) __builtin_prefetch(history[k] + s);
        if (left_stretch) __builtin_prefetch(left_stretch + s);
#endif
    }
};

/// Which optional columns a scene needs.
struct ColumnNeeds {
    bool affine = false;
    bool left_stretch = false;
    bool log_stretch = false;
    int history = 0;
    bool body_force = false;
};

/// A column as bytes, for packing, files and hashes.
struct ColumnBytes {
    std::string name;
    std::string unit;
    std::size_t row_bytes;
    std::size_t scalar_bytes;
    std::byte* data;
};

template <class Space, class Real, int Dim>
class Particles {
  public:
    explicit Particles(const ColumnNeeds& needs) : needs_(needs) {}

    std::size_t size() const { return id_.size(); }

    /// Makes space for n slots in every column. New slots hold anything.
    void resize(std::size_t n) {
        each_column([&](const char*, const char*, auto& column, std::size_t) { column.resize(n); });
    }

    void reserve(std::size_t n) {
        each_column([&](const char*, const char*, auto& column, std::size_t) { column.reserve(n); });
    }

    ParticleView<Real, Dim> view() {
        ParticleView<Real, Dim> v{};
        v.id = id_.data(), v.body = body_.data(), v.position = position_.data(), v.velocity = velocity_.data();
        v.mass = mass_.data(), v.volume = volume_.data(), v.ln_J = ln_J_.data(), v.stress = stress_.data();
        v.affine = needs_.affine ? affine_.data() : nullptr;
        v.left_stretch = needs_.left_stretch ? left_stretch_.data() : nullptr;
        v.log_stretch = needs_.log_stretch ? log_stretch_.data() : nullptr;
        for (int k = 0; k < max_history; ++k) v.history[k] = k < needs_.history ? history_[k].data() : nullptr;
        v.body_force = needs_.body_force ? body_force_.data() : nullptr;
        return v;
    }

    /// The state: every column but the transient body force, in a fixed order.
    std::vector<ColumnBytes> columns() {
        std::vector<ColumnBytes> all;
        each_column([&](const char* name, const char* unit, auto& column, std::size_t scalar) {
            if (std::string(name) == "body_force") return;
            all.push_back({name, unit, sizeof(*column.data()), scalar, reinterpret_cast<std::byte*>(column.data())});
        });
        return all;
    }

    /// Bytes of one particle in all columns.
    std::size_t row_bytes() {
        std::size_t sum = 0;
        for (const ColumnBytes& c : columns()) sum += c.row_bytes;
        return sum;
    }

    /// Slot k takes what was in slot order[k]; one column at a time, so that the spare memory is one column.
    void permute(const std::uint32_t* order, std::size_t n) {
        each_column([&](const char*, const char*, auto& column, std::size_t) {
            std::remove_reference_t<decltype(column)> fresh;
            fresh.resize(n);
            auto* to = fresh.data();
            const auto* from = column.data();
            Space::launch(static_cast<std::int64_t>(n), [=](int k) { to[k] = from[order[k]]; });
            column.swap(fresh);
        });
    }

  private:
    template <class T>
    using Array = typename Space::template Array<T>;

    template <class F>
    void each_column(const F& f) {
        f("id", "", id_, 8);
        f("body", "", body_, 2);
        f("position", "cell", position_, sizeof(Real));
        f("velocity", "m/s", velocity_, sizeof(Real));
        f("mass", "kg", mass_, sizeof(Real));
        f("volume", "m3", volume_, sizeof(Real));
        f("ln_J", "", ln_J_, sizeof(Real));
        f("stress", "Pa", stress_, sizeof(Real));
        if (needs_.affine) f("affine", "1/s", affine_, sizeof(Real));
        if (needs_.left_stretch) f("left_strain", "", left_stretch_, sizeof(Real));
        if (needs_.log_stretch) f("log_stretch", "", log_stretch_, sizeof(Real));
        if (needs_.history > 0) f("history_0", "", history_[0], sizeof(Real));
        if (needs_.history > 1) f("history_1", "", history_[1], sizeof(Real));
        if (needs_.body_force) f("body_force", "m/s2", body_force_, sizeof(Real));
    }

    ColumnNeeds needs_;
    Array<std::uint64_t> id_;
    Array<std::uint16_t> body_;
    Array<Vec<Coordinate<Real>, Dim>> position_;
    Array<Vec<Real, Dim>> velocity_;
    Array<Real> mass_, volume_, ln_J_;
    Array<Sym<Real, Dim>> stress_;
    Array<Mat<Real, Dim>> affine_;
    Array<Sym<Real, Dim>> left_stretch_;
    Array<Vec<Real, Dim>> log_stretch_;
    Array<Real> history_[max_history];
    Array<Vec<Real, Dim>> body_force_;
};

}  // namespace moraine
