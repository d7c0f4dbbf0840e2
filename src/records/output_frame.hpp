#pragma once
// One output of particles.vtkhdf: position, id and the fields that the scene names, in list order.
//
// Columns are made one at a time while they are written.

#include "io/vtkhdf.hpp"
#include "records/checkpoint_state.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine {

template <class Real, int Dim>
class OutputFrame {
  public:
    /// Binned state only. Not collective.
    explicit OutputFrame(Simulation<Real, Dim>& sim) : sim_(sim) {
        stored("id", "id");
        for (const std::string& field : sim.scene().output.fields) add(field);
    }

    /// Collective.
    void append_to(ParticleSeries& series) const {
        Column position = {"position", "m", Column::Type::f64, Dim};
        position.make = [this](std::byte* rows) {
            auto* at = reinterpret_cast<double*>(rows);
            sim_.each_piece({"position"}, [&](const SharePiece<Real, Dim>& piece) {
                for (int b = piece.begin; b < piece.end; ++b)
                    for (std::uint32_t s : piece.slots(b)) {
                        const std::array<double, Dim> x = place_of(sim_, piece, b, s);
                        at = std::copy(x.begin(), x.end(), at);
                    }
            });
        };
        series.append(sim_.clock().time, block_rows(sim_), position, fields_);
    }

  private:
    void add(const std::string& field) {
        using View = ParticleView<Real, Dim>;
        if (field == "pressure") {
            derived(field, "Pa", {"stress"},
                    [](const View& p, std::uint32_t s) { return -static_cast<double>(p.stress[s].trace()) / 3; });
        } else if (field == "density") {
            derived(field, "kg/m3", {"mass", "volume"}, [](const View& p, std::uint32_t s) {
                return static_cast<double>(p.mass[s]) / static_cast<double>(p.volume[s]);
            });
        } else {
            for (const MaterialSpec& m : sim_.scene().materials) {
                const LawInfo& law = *find_law(m.law);
                for (std::size_t k = 0; k < law.history_names.size(); ++k)
                    if (field == law.history_names[k]) return stored(field, "history_" + std::to_string(k));
            }
            stored(field, field);
        }
    }

    /// f(particles, slot), of the columns that it needs.
    template <class F>
    void derived(const std::string& field, const std::string& unit, const std::vector<std::string>& needs, const F& f) {
        Column column = {field, unit, Column::Type::f64};
        column.make = [this, needs, f](std::byte* rows) {
            auto* at = reinterpret_cast<double*>(rows);
            sim_.each_piece(needs, [&](const SharePiece<Real, Dim>& piece) {
                for (std::uint32_t s : piece.slots()) *at++ = f(piece.p, s);
            });
        };
        fields_.push_back(std::move(column));
    }

    /// A column of the particles under another name.
    void stored(const std::string& field, const std::string& name) {
        for (const ColumnBytes& c : sim_.columns())
            if (c.name == name) {
                fields_.push_back(listed_column(sim_, c));
                fields_.back().name = field;
            }
    }

    Simulation<Real, Dim>& sim_;
    std::vector<Column> fields_;
};

}  // namespace moraine
