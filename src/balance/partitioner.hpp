#pragma once
// A partitioner: weights in, owners out. Which rank owns a block decides speed, never the answer.
//
// A pure function of replicated data: every rank calls it with the same blocks and gets the same
// owners. Our own partitioners compute them on every rank and send nothing; what a library says is computed by
// one rank and sent (one_rank.hpp). Moving the blocks is somebody else's work. Ownership is a table from
// block to rank, not P + 1 positions on a curve, because not every partitioner follows one.
//
// Static partitioners fix at the start of the run who owns which place. They know the owner of a block
// before it is occupied; for the others a new block goes to the owner of its first occupied neighbour.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "balance/load.hpp"
#include "comm/comm.hpp"
#include "comm/host_groups.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

/// How an owner for each block was found, given what the ranks hold now.
enum class PlanKind {
    keep,        ///< the present owners
    natural,     ///< part p to rank p, or whatever the partitioner itself says
    relabelled,  ///< parts to the ranks that hold most of them
    least        ///< a cut that moves least, nearly as balanced
};
inline constexpr std::size_t plan_kinds = 4;

struct Option {
    PlanKind kind;
    std::vector<std::int32_t> owners;
};

class Partitioner {
  public:
    virtual ~Partitioner() = default;

    virtual const char* name() const = 0;

    /// The place decides, for the whole run: repartitioning changes nothing and is not tried.
    virtual bool is_static() const { return false; }

    /// Ranks compute owners() and options() together, on the thread that speaks MPI; else each for itself, on any.
    virtual bool is_collective() const { return false; }

    /// The blocks at the start of the run, once before owners(); not after a successful restore().
    /// Not collective.
    virtual void start(std::span<const BlockLoad>) {}

    /// A rank for each block. `round` counts the partitions of this run, from 0. Collective: see make_partitioner.
    virtual std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t round) const = 0;

    /// Owners to choose from when blocks have owners already; never none. Collective, as owners() is.
    virtual std::vector<Option> options(std::span<const BlockLoad> blocks, std::int64_t round) const {
        return {{PlanKind::natural, owners(blocks, round)}};
    }

    /// The same with no more than `most` particles on any rank; empty where there is no such cut, nothing of a
    /// partitioner that does not look for one. Not collective.
    virtual std::optional<std::vector<Option>> options_within(std::span<const BlockLoad> /*blocks*/,
                                                              std::int64_t /*most*/) const {
        return std::nullopt;
    }

    /// The rank that owns this place, also outside the domain; -1: take that of the first occupied
    /// neighbour, in offset order. Not collective.
    virtual std::int32_t owner_at(const Position&) const { return -1; }

    /// What a checkpoint must keep; it serves a restart on any number of ranks. Not collective.
    virtual std::vector<std::int64_t> state() const { return {}; }

    /// Takes state() of a partitioner of the same name. False: it was made for another axis or domain
    /// and nothing is taken; call start() with the blocks of now instead. Not collective.
    virtual bool restore(std::span<const std::int64_t> state) { return state.empty(); }
};

/// The names that make_partitioner knows, in the order of the documentation. Not collective.
const std::vector<std::string>& partitioner_names();

/// Was this program built with what the partitioner needs (Zoltan, METIS)? Not collective.
bool is_built(const std::string& partitioner);

/// Throws InputError for a name that it does not know or was built without, or an axis that the scene has not.
/// ranks >= 1. Its owners() is for a rank on its own, and not collective. `hosts`: of each rank, or nothing: one host.
std::unique_ptr<Partitioner> make_partitioner(const BalanceSpec& spec, const Layout& layout, int ranks,
                                              const HostOfRank& hosts = {});

/// For the ranks of a run: all call owners() and options() together, and all get the same. Comm must outlive it.
/// Not collective.
std::unique_ptr<Partitioner> make_partitioner(const BalanceSpec& spec, const Layout& layout, const Comm& comm,
                                              const HostOfRank& hosts = {});

}  // namespace moraine
