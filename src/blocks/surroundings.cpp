#include "blocks/surroundings.hpp"

namespace moraine {

template <int Dim>
constexpr std::array<typename Surroundings<Dim>::Cell, Surroundings<Dim>::places> Surroundings<Dim>::regular =
    cells_of(std::array<Axis, Dim>{});

template <int Dim>
constexpr std::array<Places, Surroundings<Dim>::slots> Surroundings<Dim>::places_of_slot = [] {
    std::array<Places, slots> of{};
    for (std::size_t p = 0; p < places; ++p) of[regular[p].slot] |= Places(1) << p;
    return of;
}();

template <int Dim>
Surroundings<Dim>::Surroundings(const DomainBlocks<Dim>& domain, Key parent, Ends ends) {
    unsigned everywhere = 15;
    for (int a = 0; a < Dim; ++a) {
        // The neighbours of one coordinate among interleaved bits: the others' are filled so that a carry passes.
        constexpr Key every = Morton<Dim>::spread(~Key(0));
        const Key bits = every << a;
        const Key here = parent & bits;
        const auto s = static_cast<std::size_t>(a);
        axis_[s].parent = {(here - 1) & bits, here, ((here | ~bits) + 1) & bits};
        if (!domain.periodic[s] && ends == Ends::open) continue;
        const auto first = static_cast<std::int32_t>(2 * static_cast<std::int64_t>(Morton<Dim>::gather(parent >> a)) -
                                                     Morton<Dim>::bias - 1);
        if (first < 0 || first + 3 >= domain.count[s]) set_end(domain, a, first);
        everywhere &= axis_[s].inside;
    }
    if (cut_) cells_ = cells_of(axis_);
    if (everywhere == 15) return;
    inside_ = 0;
    for (int p = 0; p < places; ++p) {
        bool in = true;
        for (int a = 0; a < Dim; ++a) in = in && (axis_[static_cast<std::size_t>(a)].inside >> (p >> (2 * a) & 3) & 1u);
        inside_ |= Places(in) << p;
    }
}

template <int Dim>
void Surroundings<Dim>::set_end(const DomainBlocks<Dim>& domain, int a, std::int32_t first) {
    Axis& axis = axis_[static_cast<std::size_t>(a)];
    const std::int32_t count = domain.count[static_cast<std::size_t>(a)];
    axis.inside = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        std::int32_t at = first + static_cast<std::int32_t>(k);
        if (domain.periodic[static_cast<std::size_t>(a)]) at = (at % count + count) % count;
        axis.inside |= unsigned(at >= 0 && at < count) << k;
        const auto half = static_cast<Key>(static_cast<std::int64_t>(at) + Morton<Dim>::bias) >> 1;
        const Key parent = Morton<Dim>::spread(half) << a;
        if (k == 2 && parent != axis.parent[1]) axis.slot[k] = 2;  // the seam lies between the family's own places
        axis.parent[axis.slot[k]] = parent;
        const auto child = static_cast<std::uint8_t>(at & 1);
        cut_ = cut_ || axis.slot[k] != Axis{}.slot[k] || axis.child[k] != child;
        axis.child[k] = child;
    }
}

template class Surroundings<2>;
template class Surroundings<3>;

}  // namespace moraine
