#include "balance/partitioner.hpp"

#include "balance/morton_partitioner.hpp"
#include "balance/shuffle.hpp"
#include "balance/slabs.hpp"
#include "balance/slabs_initial.hpp"
#include "core/error.hpp"

namespace moraine {
namespace {

int checked_axis(const BalanceSpec& spec, const Layout& layout) {
    if (spec.axis < 0 || spec.axis >= layout.dimensions)
        throw InputError("balance.axis = " + std::to_string(spec.axis) + " (a scene of " +
                         std::to_string(layout.dimensions) + " dimensions has the axes 0 to " +
                         std::to_string(layout.dimensions - 1) + "). Use 0?");
    return spec.axis;
}

template <class Made>
std::unique_ptr<Partitioner> make_plain(const BalanceSpec&, const Layout&, int ranks) {
    return std::make_unique<Made>(ranks);
}

template <class Made>
std::unique_ptr<Partitioner> make_slabs(const BalanceSpec& spec, const Layout& layout, int ranks) {
    return std::make_unique<Made>(layout, checked_axis(spec, layout), ranks);
}

/// Where names become objects: a new partitioner is one file and one line here.
struct Entry {
    const char* name;
    std::unique_ptr<Partitioner> (*make)(const BalanceSpec&, const Layout&, int ranks);
};
constexpr Entry entries[] = {
    {"morton", make_plain<MortonPartitioner>},
    {"slabs", make_slabs<Slabs>},
    {"slabs-initial", make_slabs<SlabsInitial>},
    {"shuffle", make_plain<Shuffle>},
};

}  // namespace

const std::vector<std::string>& partitioner_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const Entry& entry : entries) list.push_back(entry.name);
        return list;
    }();
    return names;
}

std::unique_ptr<Partitioner> make_partitioner(const BalanceSpec& spec, const Layout& layout, int ranks) {
    std::string valid;
    for (const Entry& entry : entries) {
        if (spec.partitioner == entry.name) return entry.make(spec, layout, ranks);
        valid += (valid.empty() ? "" : ", ") + std::string(entry.name);
    }
    throw InputError("balance.partitioner = \"" + spec.partitioner + "\" (no such partitioner). Use one of " + valid +
                     "?");
}

}  // namespace moraine
