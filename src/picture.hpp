#pragma once
// One output of particles.vtkhdf: position, id and the fields that the scene names, in list order.

#include <deque>

#include "io/vtkhdf.hpp"
#include "simulation.hpp"
#include "store.hpp"

namespace moraine {

template <class Space, class Real, int Dim>
class Picture {
  public:
    /// Filed state only. Not collective.
    explicit Picture(Simulation<Space, Real, Dim>& sim) : sim_(sim), filed_(sim.patch().filed()) {
        std::vector<double>& x = store();
        sim.each_particle(
            [&](std::uint32_t, const std::array<double, Dim>& at) { x.insert(x.end(), at.begin(), at.end()); });
        position_ = Column::of("position", "m", x.data(), Dim);
        stored("id", "id");
        for (const std::string& field : sim.scene().output.fields) add(field);
    }

    /// Collective.
    void append_to(ParticleSeries& series) const {
        series.append(sim_.clock().time, block_rows(filed_), position_, fields_);
    }

  private:
    std::vector<double>& store() { return numbers_.emplace_back(); }

    void add(const std::string& field) {
        const ParticleView<Real, Dim> p = sim_.patch().particles.view();
        if (field == "pressure") {
            derived(field, "Pa", [&](std::uint32_t s) { return -static_cast<double>(p.stress[s].trace()) / 3; });
        } else if (field == "density") {
            derived(field, "kg/m3",
                    [&](std::uint32_t s) { return static_cast<double>(p.mass[s]) / static_cast<double>(p.volume[s]); });
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
        std::vector<double>& values = store();
        for (std::uint32_t s : filed_.slot) values.push_back(f(s));
        fields_.push_back(Column::of(field, unit, values.data()));
    }

    /// A column of the particles under another name.
    void stored(const std::string& field, const std::string& column) {
        for (const ColumnBytes& c : sim_.patch().particles.columns()) {
            if (c.name != column) continue;
            std::vector<std::byte>& rows = rows_.emplace_back(padded(c.row_bytes * filed_.slot.size()));
            gather_rows({c}, filed_.slot, rows.data());
            fields_.push_back(file_column(c, rows.data()));
            fields_.back().name = field;
        }
    }

    Simulation<Space, Real, Dim>& sim_;
    FiledBlocks filed_;
    Column position_;
    std::vector<Column> fields_;
    std::deque<std::vector<double>> numbers_;
    std::deque<std::vector<std::byte>> rows_;
};

}  // namespace moraine
