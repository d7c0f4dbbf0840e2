#include "blocks/contact_pairs.hpp"

#include "core/data/host.hpp"
#include "core/data/morton.hpp"

namespace moraine {

template <int Dim>
bool ContactPairs<Dim>::make(const EpochTables<Dim>& tables, const ContactField<Dim>& field, bool moved) {
    if (made_ && !moved) return false;
    made_ = true;
    structures_ = field.count;
    const auto own = tables.own.size(), count = static_cast<std::size_t>(structures_);
    tile_of_.resize((own + tables.ghost.size()) * count);
    const bool grounded = count > 0 && field.structure[0].shape == StructureShape::ground;
    bounds_.resize(grounded ? own + tables.ghost.size() : 0);
    Host::launch(static_cast<std::int64_t>(own + tables.ghost.size()), [&](int block) {
        const auto b = static_cast<std::size_t>(block);
        Vec<std::int32_t, Dim> at;
        if (b < own) {
            at = tables.position[b];
        } else {
            const auto place = Morton<Dim>::decode(tables.ghost[b - own]);
            for (int a = 0; a < Dim; ++a) at[a] = static_cast<std::int32_t>(place[static_cast<std::size_t>(a)]);
        }
        for (std::size_t k = 0; k < count; ++k)
            tile_of_[b * count + k] = is_near_block(field, field.structure[k], at) ? 0 : -1;
        if (!grounded || tile_of_[b * count] < 0) return;
        bounds_[b] = bound_of_block(field, field.structure[0], at);
        if (bounds_[b].is_clear_block(2 * field.cell)) tile_of_[b * count] = -1;
    });
    tiles_ = 0;
    for (std::int32_t& tile : tile_of_)
        if (tile == 0) tile = static_cast<std::int32_t>(tiles_++);
    list(tables.boundary, boundary_);
    list(tables.interior, interior_);
    return true;
}

template <int Dim>
void ContactPairs<Dim>::list(const std::vector<std::int32_t>& blocks, std::vector<ContactPair>& pairs) const {
    pairs.clear();
    for (std::int32_t block : blocks)
        for (std::int32_t k = 0; k < structures_; ++k) {
            const std::int32_t tile = tile_of_[static_cast<std::size_t>(block * structures_ + k)];
            if (tile >= 0) pairs.push_back({block, k, tile});
        }
}

template class ContactPairs<2>;
template class ContactPairs<3>;

}  // namespace moraine
