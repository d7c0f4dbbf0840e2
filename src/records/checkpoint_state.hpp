#pragma once
// A simulation to and from its checkpoint. Both collective.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

#include "core/data/error.hpp"
#include "core/gravity.hpp"
#include "core/particles/particle_bytes.hpp"
#include "io/checkpoint.hpp"
#include "io/input_error.hpp"
#include "records/checkpoint_header.hpp"
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
    if (set.any_turns()) {
        std::vector<TurningSums<Dim>> turning;
        for (const StructureState<Dim>& state : set.states()) turning.push_back(state.pending_turning);
        turning = comm.exact_sums(turning);
        for (std::size_t k = 0; k < set.size(); ++k) set.states()[k].pending_turning = turning[k];
    }
    each_structure_sum(
        set, [&](const std::string& name, const ExactSum& all) { header["structure_" + name] = stored_sum(all); });
    std::vector<double> motion{set.reported_time};
    each_structure_value(set, [&](double& value) { motion.push_back(value); });
    header["structure_motion"] = motion;
    if (set.collisions()) header["structure_collisions"] = set.collisions()->stored();
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
    std::size_t count = 1;
    each_structure_value(set, [&](double&) { ++count; });
    if (motion.size() != count || !std::all_of(motion.begin(), motion.end(), [](double x) { return std::isfinite(x); }))
        file.refuse("it does not hold these structures");
    set.reported_time = motion[0];
    auto from = motion.begin() + 1;
    each_structure_value(set, [&](double& value) { value = *from++; });
    if (set.collisions() && !set.collisions()->restore(file.get<std::vector<double>>("structure_collisions")))
        file.refuse("it does not hold what these structures give each other");
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
    if (!sim.scene().course.tractions.empty()) each_load_entry(budget, store);
    if (sim.scene().water.on) each_water_entry(budget, store);
    if (gravity_changes(sim.scene())) save_gravity(sim.clock(), budget, header);
    if (sim.stage()) header["stages"] = stored_stages(sim.clock().stages);

    if (!sim.clock().ends.empty()) header["ends"] = stored_ends(sim.clock().ends);
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
    if (!sim.scene().course.tractions.empty()) each_load_entry(budget, take);
    if (sim.scene().water.on) each_water_entry(budget, take);
    if (gravity_changes(sim.scene())) take_gravity(file, clock, budget);
    take_ends(file, clock);
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
