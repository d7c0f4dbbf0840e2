// What of surfaces holds for an epoch.

#include "blocks/surface_plan.hpp"

#include "core/data/morton.hpp"
#include "core/grid/stencil.hpp"

namespace moraine {

namespace {

/// Node of a block's first cell.
template <int Dim>
Vec<std::int32_t, Dim> first_of(const Vec<std::int32_t, Dim>& block) {
    Vec<std::int32_t, Dim> node;
    for (int a = 0; a < Dim; ++a) node[a] = first_node<Quadratic>(block[a]) + 1;
    return node;
}

}  // namespace

template <int Dim>
void SurfacePlan<Dim>::make(const EpochTables<Dim>& tables, const ContactField<Dim>& of, bool moves) {
    field_ = of;
    constexpr std::size_t kept = 4, always = 4096;  // times those of an epoch, and blocks
    if (moves || block_count_ > kept * blocks.size() + always) forget();
    list_blocks(tables);
    list_nodes(tables);
}

template <int Dim>
void SurfacePlan<Dim>::forget() {
    ++generation;
    geometry_.forget();
    found_.clear(), found_nodes_.clear(), near_.clear();
    block_count_ = node_count_ = 0;
}

/// Whether a block may have a cell or a node that a surface is near: by the distance of its middle.
template <int Dim>
bool SurfacePlan<Dim>::is_near(const Place& block) const {
    constexpr double reach = 3.5 + 2 * (Dim == 2 ? 1.4143 : 1.7321);
    const Place first = first_of(block);
    for (int k = 0; k < field_.count; ++k) {
        const Structure<Dim>& s = field_.structure[k];
        if (distance_bound(s, field_.corners, node_place(field_, s, &first[0], 1.5)) < reach * h) return true;
    }
    return false;
}

/// Of an own block; null: no surface is near.
template <int Dim>
SurfaceBlock<Dim>* SurfacePlan<Dim>::block(Key key, const Place& place) {
    const auto [at, is_new] = found_.try_emplace(key);
    if (!is_new || !is_near(place)) return at->second.get();
    at->second = std::make_unique<SurfaceBlock<Dim>>(make_surface_block(first_of(place), field_, h, geometry_));
    at->second->number = block_count_++;
    return at->second.get();
}

template <int Dim>
const SurfaceNodes<Dim>* SurfacePlan<Dim>::node_block(Key key, const Place& place) {
    const auto [at, is_new] = found_nodes_.try_emplace(key);
    if (!is_new) return at->second.get();
    at->second = std::make_unique<SurfaceNodes<Dim>>();
    at->second->number = node_count_++;
    for (int n = 0; n < cells; ++n) {
        Place node = place;
        for (int a = 0; a < Dim; ++a) node[a] = 4 * node[a] - origin + cell_coordinate<Dim>(n, a);
        const SurfaceNode<Dim> found = geometry_.node(node);
        at->second->node[n] = {found.distance, found.capacity};
    }
    return at->second.get();
}

template <int Dim>
void SurfacePlan<Dim>::list_blocks(const EpochTables<Dim>& tables) {
    const std::size_t own = tables.own.size();
    ghosts = tables.ghost.size();
    blocks.clear(), block_at.clear();
    bed_of.assign(own + ghosts, -1);
    for (std::size_t b = 0; b < own; ++b) {
        SurfaceBlock<Dim>* found = block(tables.own[b], tables.position[b]);
        if (!found) continue;
        bed_of[b] = static_cast<std::int32_t>(blocks.size());
        blocks.push_back(static_cast<std::int32_t>(b));
        block_at.push_back(found);
    }
    for (std::size_t g = 0; g < ghosts; ++g) {
        const auto [near, is_new] = near_.try_emplace(tables.ghost[g], false);
        if (is_new) {
            const auto at = Morton<Dim>::decode(tables.ghost[g]);
            Place place;
            for (int a = 0; a < Dim; ++a) place[a] = static_cast<std::int32_t>(at[static_cast<std::size_t>(a)]);
            near->second = is_near(place);
        }
        if (near->second) bed_of[own + g] = 0;
    }
}

template <int Dim>
void SurfacePlan<Dim>::list_nodes(const EpochTables<Dim>& tables) {
    near_nodes.clear(), nodes_at.clear(), node_at.clear();
    near_of.assign(tables.node_position.size(), -1);
    for (std::size_t c = 0; c < near_of.size(); ++c)
        for (int d = 0; d < Block<Dim>::corners; ++d) {
            const std::int32_t source = tables.source[c * Block<Dim>::corners + static_cast<std::size_t>(d)];
            if (source < 0 || bed_of[static_cast<std::size_t>(source)] < 0) continue;
            near_of[c] = static_cast<std::int32_t>(near_nodes.size());
            near_nodes.push_back(static_cast<std::int32_t>(c));
            nodes_at.push_back(node_block(tables.node_key[c], tables.node_position[c]));
            node_at.push_back(nodes_at.back()->node);
            break;
        }
}

template class SurfacePlan<2>;
template class SurfacePlan<3>;

}  // namespace moraine
