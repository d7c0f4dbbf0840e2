#pragma once
// One output of particles.vtkhdf: position, id and the fields that the scene names, in list order.
//
// Columns are made one at a time while they are written.

#include "io/vtkhdf.hpp"
#include "simulation.hpp"
#include "store.hpp"

namespace moraine {

template <class Real, int Dim>
class Picture {
  public:
    /// Filed state only. Not collective.
    explicit Picture(Simulation<Real, Dim>& sim)
        : sim_(sim), filed_(sim.patch().filed()), view_(sim.patch().particles.view()) {
        stored("id", "id");
        for (const std::string& field : sim.scene().output.fields) add(field);
    }

    /// Collective.
    void append_to(ParticleSeries& series) const {
        Column position = {"position", "m", Column::Type::f64, Dim};
        position.make = [this](std::byte* rows) {
            auto* at = reinterpret_cast<double*>(rows);
            sim_.each_particle(
                [&](std::uint32_t, const std::array<double, Dim>& x) { at = std::copy(x.begin(), x.end(), at); });
        };
        series.append(sim_.clock().time, block_rows(filed_), position, fields_);
    }

  private:
    void add(const std::string& field) {
        const ParticleView<Real, Dim> p = view_;
        if (field == "pressure") {
            derived(field, "Pa", [p](std::uint32_t s) { return -static_cast<double>(p.stress[s].trace()) / 3; });
        } else if (field == "density") {
            derived(field, "kg/m3",
                    [p](std::uint32_t s) { return static_cast<double>(p.mass[s]) / static_cast<double>(p.volume[s]); });
        } else {
            for (const MaterialSpec& m : sim_.scene().materials) {
                const LawInfo& law = *find_law(m.law);
                for (std::size_t k = 0; k < law.history_names.size(); ++k)
                    if (field == law.history_names[k]) return stored(field, "history_" + std::to_string(k));
            }
            stored(field, field);
        }
    }

    template <class F>
    void derived(const std::string& field, const std::string& unit, const F& f) {
        Column column = {field, unit, Column::Type::f64};
        column.make = [this, f](std::byte* rows) {
            auto* at = reinterpret_cast<double*>(rows);
            for (std::uint32_t s : filed_.slot) *at++ = f(s);
        };
        fields_.push_back(std::move(column));
    }

    /// A column of the particles under another name.
    void stored(const std::string& field, const std::string& name) {
        for (const ColumnBytes& c : sim_.patch().particles.columns())
            if (c.name == name) {
                fields_.push_back(listed_column(c, filed_.slot));
                fields_.back().name = field;
            }
    }

    Simulation<Real, Dim>& sim_;
    FiledBlocks filed_;
    ParticleView<Real, Dim> view_;
    std::vector<Column> fields_;
};

}  // namespace moraine
