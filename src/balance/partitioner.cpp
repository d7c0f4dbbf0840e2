#include "balance/partitioner.hpp"

#include "balance/cartesian.hpp"
#include "balance/chain_partitioner.hpp"
#include "balance/library_partitioner.hpp"
#include "balance/metis.hpp"
#include "balance/one_rank.hpp"
#include "balance/shuffle.hpp"
#include "balance/slabs.hpp"
#include "balance/slabs_initial.hpp"
#include "balance/zoltan.hpp"
#include "core/data/error.hpp"

namespace moraine {
namespace {

using Blocks = std::span<const BlockLoad>;
using Made = std::unique_ptr<Partitioner>;

/// How many there are, and which share a host (nothing: all).
struct Ranks {
    int count;
    const HostOfRank& hosts;
};

int checked_axis(const BalanceSpec& spec, const Layout& layout) {
    if (spec.axis < 0 || spec.axis >= layout.dimensions)
        throw InputError("balance.axis = " + std::to_string(spec.axis) + " (a scene of " +
                         std::to_string(layout.dimensions) + " dimensions has the axes 0 to " +
                         std::to_string(layout.dimensions - 1) + "). Use 0?");
    return spec.axis;
}

Made make_morton(const BalanceSpec&, const Layout&, const Ranks& ranks) {
    return std::make_unique<ChainPartitioner>("morton", ranks.count, links_along_morton, ranks.hosts);
}

Made make_hilbert(const BalanceSpec&, const Layout& layout, const Ranks& ranks) {
    return std::make_unique<ChainPartitioner>(
        "hilbert", ranks.count, [=](Blocks blocks) { return links_along_hilbert(layout, blocks); }, ranks.hosts);
}

Made make_equal_slabs(const BalanceSpec& spec, const Layout& layout, const Ranks& ranks) {
    return std::make_unique<ChainPartitioner>(
        "equal-slabs", ranks.count,
        [=, axis = checked_axis(spec, layout)](Blocks blocks) { return links_by_layer(layout, axis, blocks); },
        ranks.hosts);
}

template <class Slabbed>
Made make_slabs(const BalanceSpec& spec, const Layout& layout, const Ranks& ranks) {
    return std::make_unique<Slabbed>(layout, checked_axis(spec, layout), ranks.count);
}

Made make_cartesian(const BalanceSpec&, const Layout& layout, const Ranks& ranks) {
    return std::make_unique<Cartesian>(layout, ranks.count);
}

template <ZoltanMethod method>
Made make_zoltan(const BalanceSpec& spec, const Layout& layout, const Ranks& ranks) {
    constexpr const char* names[] = {"rcb", "hsfc", "phg"};
    const auto find = [layout, steps = spec.interval](Blocks blocks, int parts) {
        return zoltan_parts(method, layout, steps, blocks, parts);
    };
    return std::make_unique<LibraryPartitioner>(names[static_cast<int>(method)], ranks.count, find, ranks.hosts);
}

Made make_metis(const BalanceSpec&, const Layout& layout, const Ranks& ranks) {
    return std::make_unique<LibraryPartitioner>(
        "metis", ranks.count, [layout](Blocks blocks, int parts) { return metis_parts(layout, blocks, parts); },
        ranks.hosts);
}

Made make_shuffle(const BalanceSpec&, const Layout&, const Ranks& ranks) {
    return std::make_unique<Shuffle>(ranks.count);
}

/// What a partitioner needs besides this program.
struct Library {
    const char* name;
    const char* option;
    bool (*is_built)();
};
constexpr Library zoltan{"Zoltan", "MORAINE_ZOLTAN", zoltan_is_built};
constexpr Library metis{"METIS", "MORAINE_METIS", metis_is_built};

/// Where names become objects: a new partitioner is one file and one line here.
struct Entry {
    const char* name;
    Made (*make)(const BalanceSpec&, const Layout&, const Ranks& ranks);
    const Library* library = nullptr;

    bool is_built() const { return !library || library->is_built(); }
};
constexpr Entry entries[] = {
    {"morton", make_morton},
    {"hilbert", make_hilbert},
    {"slabs", make_slabs<Slabs>},
    {"slabs-initial", make_slabs<SlabsInitial>},
    {"cartesian", make_cartesian},
    {"equal-slabs", make_equal_slabs},
    {"rcb", make_zoltan<ZoltanMethod::rcb>, &zoltan},
    {"hsfc", make_zoltan<ZoltanMethod::hsfc>, &zoltan},
    {"phg", make_zoltan<ZoltanMethod::phg>, &zoltan},
    {"metis", make_metis, &metis},
    {"shuffle", make_shuffle},
};

const Entry* find_entry(const std::string& name) {
    for (const Entry& entry : entries)
        if (name == entry.name) return &entry;
    return nullptr;
}

/// An entry that can be made, or InputError.
const Entry& checked_entry(const std::string& name) {
    const Entry* entry = find_entry(name);
    if (entry && entry->is_built()) return *entry;
    std::string valid;
    for (const Entry& other : entries)
        if (other.is_built()) valid += (valid.empty() ? "" : ", ") + std::string(other.name);
    const std::string why = entry ? "this program was built without " + std::string(entry->library->name) +
                                        ", option " + entry->library->option
                                  : "no such partitioner";
    throw InputError("balance.partitioner = \"" + name + "\" (" + why + "). Use one of " + valid + "?");
}

}  // namespace

const std::vector<std::string>& partitioner_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const Entry& entry : entries) list.push_back(entry.name);
        return list;
    }();
    return names;
}

bool is_built(const std::string& partitioner) {
    const Entry* entry = find_entry(partitioner);
    return entry && entry->is_built();
}

std::unique_ptr<Partitioner> make_partitioner(const BalanceSpec& spec, const Layout& layout, int ranks,
                                              const HostOfRank& hosts) {
    return checked_entry(spec.partitioner).make(spec, layout, {ranks, hosts});
}

std::unique_ptr<Partitioner> make_partitioner(const BalanceSpec& spec, const Layout& layout, const Comm& comm,
                                              const HostOfRank& hosts) {
    const Entry& entry = checked_entry(spec.partitioner);
    std::unique_ptr<Partitioner> made = entry.make(spec, layout, {comm.size(), hosts});
    if (!entry.library) return made;
    return std::make_unique<OneRank>(std::move(made), comm);
}

}  // namespace moraine
