#pragma once
// A simulation to and from its checkpoint. Both collective.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

#include "core/data/error.hpp"
#include "core/particles/particle_bytes.hpp"
#include "io/checkpoint.hpp"
#include "io/input_error.hpp"
#include "scene/scene_changes.hpp"
#include "scene/scene_identity.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine {

/// A column in the terms of the files. Positions are fixed point, ids and bodies whole numbers.
inline Column file_column(const ColumnBytes& c) {
    Column column;
    column.name = c.name;
    column.unit = c.unit.empty() ? "-" : c.unit;
    const bool whole = c.name == "id" || c.name == "body" || c.name == "position" || c.name.starts_with("rest_");
    column.type = c.scalar_bytes == 2   ? Column::Type::u16
                  : c.scalar_bytes == 4 ? (whole ? Column::Type::u32 : Column::Type::f32)
                                        : (whole ? Column::Type::u64 : Column::Type::f64);
    column.components = static_cast<int>(c.row_bytes / c.scalar_bytes);
    return column;
}

/// The same with its rows in list order, made piece by piece when they are written. `sim` must outlive it.
template <class Real, int Dim>
Column listed_column(const Simulation<Real, Dim>& sim, const ColumnBytes& kind) {
    Column column = file_column(kind);
    column.make = [&sim, name = kind.name](std::byte* rows) {
        sim.each_piece({name}, [&](const SharePiece<Real, Dim>& piece) {
            const ColumnBytes& c = piece.columns.front();
            pack_column(c, piece.slots(), rows);
            rows += piece.slots().size() * c.row_bytes;
        });
    };
    return column;
}

/// This rank's blocks as rows of a file, keys ascending. Binned state only. Not collective.
template <class Real, int Dim>
std::vector<BlockRow> block_rows(Simulation<Real, Dim>& sim) {
    const BlockCounts counts = sim.block_counts();
    std::vector<BlockRow> rows;
    for (std::size_t b = 0; b < counts.key.size(); ++b)
        rows.push_back({counts.key[b], static_cast<std::int64_t>(counts.count[b])});
    return rows;
}

/// Names of the parts of a budget, and the parts.
template <int Dim, class F>
void each_budget_entry(Budget<Dim>& budget, const F& f) {
    f("work", budget.work);
    f("lost_mass", budget.lost_mass);
    for (std::size_t a = 0; a < Dim; ++a) {
        const std::string axis(1, "xyz"[a]);
        f("impulse_" + axis, budget.impulse[a]);
        f("lost_momentum_" + axis, budget.lost_momentum[a]);
        f("lost_pull_" + axis, budget.lost_gravity_impulse[a]);
    }
}

/// The same of what sleep took; only in scenes with sleep.
template <int Dim, class F>
void each_sleep_entry(Budget<Dim>& budget, const F& f) {
    f("slept_kinetic", budget.slept_kinetic);
    for (std::size_t a = 0; a < Dim; ++a) f("slept_momentum_" + std::string(1, "xyz"[a]), budget.slept_momentum[a]);
}

/// The same of the energy budget; only in scenes that want it. has_surfaces: they act where they are.
template <int Dim, class F>
void each_energy_entry(Budget<Dim>& budget, bool has_surfaces, const F& f) {
    EnergyAccount& energy = budget.energy;
    f("energy_gain", energy.nodes.gain);
    f("energy_fall", energy.nodes.fall);
    f("energy_contact", energy.nodes.contact);
    f("energy_damping", energy.nodes.damping);
    f("energy_walls", energy.nodes.walls);
    f("energy_put_out", energy.put_out);
    f("energy_lost_kinetic", energy.lost_kinetic);
    f("energy_lost_potential", energy.lost_potential);
    if (!has_surfaces) return;
    f("energy_slaves", energy.nodes.slaves);
    f("energy_pressures", energy.pressures);
}

/// A sum over ranks, as a checkpoint holds it.
inline std::vector<std::int64_t> stored_sum(const ExactSum& sum) {
    return {sum.high, std::bit_cast<std::int64_t>(sum.low)};
}
inline ExactSum sum_of_stored(const CheckpointReader& file, const std::string& name) {
    const auto& words = file.get<std::vector<std::int64_t>>(name);
    if (words.size() != 2) file.refuse(fmt::format("header/{} is no sum", name));
    return {words[0], std::bit_cast<std::uint64_t>(words[1])};
}

/// Gravity of the last step and the work of its changes; only in scenes in which it changes.
template <int Dim>
void save_gravity(const RunClock<Dim>& clock, Budget<Dim>& budget, CheckpointHeader& header) {
    header["gravity"] = std::vector<double>(clock.gravity.begin(), clock.gravity.end());
    header["gravity_work"] = stored_sum(budget.gravity_work);
}
template <int Dim>
void take_gravity(const CheckpointReader& file, RunClock<Dim>& clock, Budget<Dim>& budget) {
    const auto& gravity = file.get<std::vector<double>>("gravity");
    const auto finite = [](double x) { return std::isfinite(x); };
    if (gravity.size() != Dim || !std::all_of(gravity.begin(), gravity.end(), finite))
        file.refuse("no run has such a gravity");
    std::copy(gravity.begin(), gravity.end(), clock.gravity.begin());
    budget.gravity_work = sum_of_stored(file, "gravity_work");
}

/// Stages that have begun: what StageBegin holds of each; only in scenes that have stages.
inline std::vector<double> stored_stages(const std::vector<StageBegin>& stages) {
    std::vector<double> all;
    for (const StageBegin& s : stages)
        all.insert(all.end(), {s.time, static_cast<double>(s.step), s.removed_mass, s.removed_energy, s.added_mass});
    return all;
}
template <int Dim>
void take_stages(const CheckpointReader& file, std::size_t most, RunClock<Dim>& clock) {
    constexpr std::size_t words = 5;
    const auto& all = file.get<std::vector<double>>("stages");
    if (all.empty() || all.size() % words != 0 || all.size() / words > most) file.refuse("no run has such stages");
    double before = 0;
    for (std::size_t k = 0; k < all.size(); k += words) {
        const bool rises = all[k] >= before && all[k] <= clock.time;
        const bool counts = all[k + 1] >= 0 && all[k + 1] <= static_cast<double>(clock.step);
        if (!rises || !counts || !std::all_of(&all[k], &all[k] + words, [](double x) { return std::isfinite(x); }))
            file.refuse("no run has such stages");
        before = all[k];
        clock.stages.push_back({all[k], static_cast<std::int64_t>(all[k + 1]), all[k + 2], all[k + 3], all[k + 4]});
    }
}

/// Names of the sums of all structures, and the sums.
template <int Dim, class F>
void each_structure_sum(StructureSet<Dim>& set, const F& f) {
    for (std::size_t k = 0; k < set.size(); ++k) {
        StructureState<Dim>& state = set.states()[k];
        for (int q = 0; q < StructureSums<Dim>::count; ++q) {
            const std::string at = fmt::format("_{}_{}", set.spec(k).name, q);
            f("pending" + at, state.pending.sum[q]);
            f("felt" + at, state.felt.sum[q]);
            f("reported" + at, state.reported.sum[q]);
        }
    }
}

template <int Dim>
CheckpointHeader clock_header(const RunClock<Dim>& c) {
    CheckpointHeader h;
    h["step"] = c.step;
    h["round"] = c.round;
    h["clock"] = std::vector<double>{c.time,          c.dt,           c.signal,     c.mass_cutoff,
                                     c.quantum_scale, c.start_strain, c.start_mass, c.start_energy};
    if (c.square_speed > 0) std::get<std::vector<double>>(h["clock"]).push_back(c.square_speed);
    h["pull"] = std::vector<double>(c.gravity_impulse.begin(), c.gravity_impulse.end());
    h["start_momentum"] = std::vector<double>(c.start_momentum.begin(), c.start_momentum.end());
    return h;
}

/// What no run can have written, if anything is: a file can be forged, and the seal is no signature.
template <int Dim>
std::string clock_problem(const RunClock<Dim>& c, bool has_particles) {
    const auto finite = [](double x) { return std::isfinite(x); };
    const auto counts = [](std::int64_t n) { return n >= 0 && n < std::int64_t(1) << 53; };
    int exponent = 0;
    if (!counts(c.step) || !counts(c.round)) return fmt::format("step {}, round {}", c.step, c.round);
    if (!finite(c.time) || c.time < 0) return fmt::format("time {} s", c.time);
    if (!finite(c.dt) || c.dt < 0) return fmt::format("a step of {} s", c.dt);
    if (!finite(c.signal) || c.signal < 0 || (has_particles && c.signal == 0))
        return fmt::format("a signal speed of {} m/s", c.signal);
    if (!finite(c.square_speed) || c.square_speed < 0) return fmt::format("a speed of {} m2/s2", c.square_speed);
    if (has_particles && !(c.mass_cutoff >= 0 && c.mass_cutoff <= 1e-12 * c.start_mass))
        return fmt::format("nodes that count from {} kg on", c.mass_cutoff);
    if (std::frexp(c.quantum_scale, &exponent) != 0.5) return fmt::format("sums in units of 1/{}", c.quantum_scale);
    const auto all_finite = [&](const auto& list) { return std::all_of(list.begin(), list.end(), finite); };
    if (!all_finite(std::array{c.start_strain, c.start_mass, c.start_energy}) || !all_finite(c.gravity_impulse) ||
        !all_finite(c.start_momentum))
        return "a start that is not a number";
    return {};
}

template <int Dim>
RunClock<Dim> clock_of(const CheckpointReader& file) {
    RunClock<Dim> c;
    c.step = file.get<std::int64_t>("step");
    c.round = file.get<std::int64_t>("round");
    const auto& clock = file.get<std::vector<double>>("clock");
    const auto& pull = file.get<std::vector<double>>("pull");
    const auto& momentum = file.get<std::vector<double>>("start_momentum");
    if ((clock.size() != 8 && clock.size() != 9) || pull.size() != Dim || momentum.size() != Dim)
        file.refuse("it is of another number of dimensions");
    c.time = clock[0], c.dt = clock[1], c.signal = clock[2], c.mass_cutoff = clock[3], c.quantum_scale = clock[4];
    if (clock.size() == 9) c.square_speed = clock[8];
    c.start_strain = clock[5], c.start_mass = clock[6], c.start_energy = clock[7];
    std::copy(pull.begin(), pull.end(), c.gravity_impulse.begin());
    std::copy(momentum.begin(), momentum.end(), c.start_momentum.begin());
    const std::string problem = clock_problem(c, file.starts().back() > 0);
    if (!problem.empty()) file.refuse("no run has " + problem);
    return c;
}

/// When the last sleep check was.
template <int Dim>
void take_sleep_check(const CheckpointReader& file, RunClock<Dim>& clock) {
    const auto& time = file.get<std::vector<double>>("sleep_check");
    clock.sleep_step = file.get<std::int64_t>("sleep_step");
    if (time.size() != 1 || !(time[0] == -1 || (time[0] >= 0 && time[0] <= clock.time)) || clock.sleep_step < 0 ||
        clock.sleep_step > clock.step)
        file.refuse("no run has such a last sleep check");
    clock.sleep_check = time[0];
}

template <int Dim>
void take_start_potential(const CheckpointReader& file, RunClock<Dim>& clock) {
    const auto& potential = file.get<std::vector<double>>("start_potential");
    if (potential.size() != 1 || !std::isfinite(potential[0])) file.refuse("no run has such a potential energy");
    clock.start_potential = potential[0];
}

/// Collective.
template <class Real, int Dim>
void save_structures(Simulation<Real, Dim>& sim, const Comm& comm, CheckpointHeader& header) {
    StructureSet<Dim> set = sim.structures();
    if (set.empty()) return;
    std::vector<StructureSums<Dim>> sums;
    for (const StructureState<Dim>& state : set.states())
        sums.insert(sums.end(), {state.pending, state.felt, state.reported});
    sums = comm.exact_sums(sums);
    for (std::size_t k = 0; k < set.size(); ++k) {
        StructureState<Dim>& state = set.states()[k];
        state.pending = sums[3 * k], state.felt = sums[3 * k + 1], state.reported = sums[3 * k + 2];
    }
    each_structure_sum(
        set, [&](const std::string& name, const ExactSum& all) { header["structure_" + name] = stored_sum(all); });
    std::vector<double> motion{set.reported_time};
    for (const StructureState<Dim>& state : set.states()) {
        motion.insert(motion.end(), state.displacement.e, state.displacement.e + Dim);
        motion.insert(motion.end(), state.velocity.e, state.velocity.e + Dim);
        motion.insert(motion.end(), state.carried.e, state.carried.e + Dim);
    }
    header["structure_motion"] = motion;
}

/// What all ranks felt is with rank 0 from now on.
template <class Real, int Dim>
void load_structures(Simulation<Real, Dim>& sim, const Comm& comm, const CheckpointReader& file) {
    StructureSet<Dim>& set = sim.structures();
    if (set.empty()) return;
    each_structure_sum(set, [&](const std::string& name, ExactSum& mine) {
        const ExactSum all = sum_of_stored(file, "structure_" + name);
        mine = comm.is_root() ? all : ExactSum{};
    });
    const auto& motion = file.get<std::vector<double>>("structure_motion");
    if (motion.size() != 1 + 3 * Dim * set.size() ||
        !std::all_of(motion.begin(), motion.end(), [](double x) { return std::isfinite(x); }))
        file.refuse("it does not hold these structures");
    set.reported_time = motion[0];
    auto from = motion.begin() + 1;
    for (StructureState<Dim>& state : set.states()) {
        std::copy_n(from, Dim, state.displacement.e);
        std::copy_n(from + Dim, Dim, state.velocity.e);
        std::copy_n(from + 2 * Dim, Dim, state.carried.e);
        from += 3 * Dim;
    }
}

/// What of the records a restart goes on with: the last row of history.csv, by which it knows that of its own run, and
/// RunHealth::stored(), the maps so far, who rests, what went over the sections, and where structures were.
struct SavedRecords {
    std::string history_row;
    std::vector<double> health;
    std::vector<double> maps = {};            ///< HazardMaps::stored(); empty: none
    std::vector<std::int64_t> rest = {};      ///< RestWatch::stored(); empty: none
    std::vector<std::int64_t> sections = {};  ///< SectionFlow::stored(); empty: none
    std::vector<double> structure_path = {};  ///< StructurePath::stored(); empty: none
    std::string changes = {};                 ///< what restarts changed (scene_change_record.hpp)
};

/// Binned state only; after conclude().
template <class Real, int Dim>
void save(Simulation<Real, Dim>& sim, const Comm& comm, const std::string& path, const SavedRecords& records = {}) {
    CheckpointHeader header = clock_header(sim.clock());
    header["history_row"] = records.history_row;
    header["health"] = records.health;
    if (!records.maps.empty()) header["maps"] = records.maps;
    if (!records.rest.empty()) header["rest"] = records.rest;
    if (!records.sections.empty()) header["sections"] = records.sections;
    if (!records.structure_path.empty()) header["structure_path"] = records.structure_path;
    if (!records.changes.empty()) header["changes"] = records.changes;
    header["scene"] = identity_text(sim.scene());
    header["state_hash"] = std::bit_cast<std::int64_t>(state_hash(sim));
    header["partitioner"] = std::string(sim.partitioner().name());
    header["partitioner_state"] = sim.partitioner().state();
    Budget<Dim> budget = comm.exact_sum(sim.budget());
    header["lost_count"] = budget.lost_count;
    const auto store = [&](const std::string& name, const ExactSum& all) {
        header["ledger_" + name] = stored_sum(all);
    };
    each_budget_entry(budget, store);
    if (sim.scene().sleep.on) {
        each_sleep_entry(budget, store);
        header["sleep_check"] = std::vector<double>{sim.clock().sleep_check};
        header["sleep_step"] = sim.clock().sleep_step;
    }
    if (sim.scene().output.energy_budget) {
        each_energy_entry(budget, sim.scene().bed == Bed::surface, store);
        header["start_potential"] = std::vector<double>{sim.clock().start_potential};
    }
    if (!sim.scene().course.gravity.empty()) save_gravity(sim.clock(), budget, header);
    if (sim.stage()) header["stages"] = stored_stages(sim.clock().stages);

    save_structures(sim, comm, header);

    std::vector<Column> columns;
    for (const ColumnBytes& c : sim.columns()) columns.push_back(listed_column(sim, c));
    write_checkpoint(comm, path, header, block_rows(sim), columns);
}

/// What save() was told; nothing in checkpoints that know none.
inline SavedRecords saved_records(const CheckpointReader& file) {
    SavedRecords records;
    const auto take = [&]<class T>(const char* name, T& to) {
        const auto found = file.header().find(name);
        if (found == file.header().end()) return;
        if (const auto* value = std::get_if<T>(&found->second)) to = *value;
    };
    take("history_row", records.history_row);
    take("health", records.health);
    take("maps", records.maps);
    take("rest", records.rest);
    take("sections", records.sections);
    take("structure_path", records.structure_path);
    take("changes", records.changes);
    return records;
}

/// Rows of this rank's blocks. Nothing of them is used before they have the hash that was stored with them, and name
/// bodies of the scene: a row may be damaged anywhere. Collective.
template <class Real, int Dim>
void read_particles(Simulation<Real, Dim>& sim, const Comm& comm, const CheckpointReader& file, const std::string& path,
                    const std::vector<std::pair<std::int64_t, std::int64_t>>& ranges,
                    std::span<const std::uint32_t> slots) {
    std::vector<RowRange> mine;
    for (const auto& [start, count] : ranges) mine.push_back({start, count});
    const std::vector<ColumnBytes> columns = sim.patch().particles.columns();
    for (const ColumnBytes& c : columns) {
        std::vector<std::byte> rows(padded(c.row_bytes * slots.size()));
        file.read_rows(file_column(c), mine, rows.data());
        unpack_rows({c}, slots, rows.data());
    }
    std::map<std::int64_t, Key> key_at;  // of the row with which a block begins
    std::int64_t row = 0;
    for (const BlockRow& block : file.blocks()) key_at[std::exchange(row, row + block.count)] = block.key;
    std::uint64_t hash = 0;
    auto slot = slots.begin();
    for (const RowRange& block : mine)
        for (std::int64_t k = 0; k < block.count; ++k) hash += row_hash(key_at.at(block.start), columns, *slot++);
    if (std::bit_cast<std::int64_t>(comm.sum(hash)) != file.get<std::int64_t>("state_hash"))
        throw InputError(
            fmt::format("{} is damaged (its particles do not have the state_hash that was stored with them). "
                        "Restart from an earlier checkpoint?",
                        path));
    const auto* body = sim.patch().particles.view().body;
    const std::size_t bodies = sim.scene().bodies.size();
    const bool known = std::all_of(slots.begin(), slots.end(), [&](std::uint32_t s) { return body[s] < bodies; });
    if (comm.max(std::int64_t(!known)) != 0) file.refuse("its particles are of bodies that the scene lacks");
}

/// Where the key of a difference is one that a restart may be allowed to change.
inline std::string other_remedy(const Scene& scene, const std::string& difference) {
    const std::string key = difference.substr(0, difference.find(' '));
    return may_change(scene, key) && !scene.sleep.on ? ", or say --allow-change " + key : "";
}

/// Throws InputError if the file is of another scene, but for the allowed keys, or its particles are not those that
/// were stored.
template <class Real, int Dim>
void load(Simulation<Real, Dim>& sim, const Comm& comm, const CheckpointReader& file, const std::string& path,
          const std::vector<std::string>& allowed = {}) {
    const std::string difference = first_difference(sim.scene(), file.get<std::string>("scene"), allowed);
    if (!difference.empty())
        throw InputError(
            fmt::format("{} is a checkpoint of another scene ({}). Restart with the scene that wrote it{}?", path,
                        printable(difference, 500), other_remedy(sim.scene(), difference)));  // its bytes are of a file
    std::vector<Key> keys;
    std::vector<std::int64_t> counts;
    for (const BlockRow& row : file.blocks()) keys.push_back(row.key), counts.push_back(row.count);
    Budget<Dim> budget;
    budget.lost_count = file.get<std::int64_t>("lost_count");
    if (budget.lost_count < 0) file.refuse(fmt::format("no run has lost {} particles", budget.lost_count));
    const auto take = [&](const std::string& name, ExactSum& entry) { entry = sum_of_stored(file, "ledger_" + name); };
    each_budget_entry(budget, take);
    RunClock<Dim> clock = clock_of<Dim>(file);
    clock.gravity = sim.clock().gravity;  // of the start
    if (!sim.scene().course.gravity.empty()) take_gravity(file, clock, budget);
    if (sim.stage()) take_stages(file, sim.scene().course.stages.size(), clock);
    if (sim.scene().sleep.on) {
        each_sleep_entry(budget, take);
        take_sleep_check(file, clock);
    }
    if (sim.scene().output.energy_budget) {
        if (!file.header().contains("start_potential"))
            throw InputError(
                fmt::format("{} has no energy budget (output.energy_budget was off in its run). Turn it off, or run "
                            "from the start?",
                            path));
        each_energy_entry(budget, sim.scene().bed == Bed::surface, take);
        take_start_potential(file, clock);
    }
    std::vector<std::int64_t> state;
    if (file.get<std::string>("partitioner") == sim.partitioner().name())
        state = file.get<std::vector<std::int64_t>>("partitioner_state");
    const auto read = [&](const std::vector<std::pair<std::int64_t, std::int64_t>>& ranges,
                          std::span<const std::uint32_t> slots) {
        read_particles(sim, comm, file, path, ranges, slots);
    };
    sim.restore(keys, counts, clock, budget, state, read);
    load_structures(sim, comm, file);
}

}  // namespace moraine
