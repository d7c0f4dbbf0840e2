// What of surfaces holds for an epoch.

#include "blocks/surface_plan.hpp"

#include <omp.h>

#include <cmath>

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

template <int Dim>
Key key_of(const Vec<std::int32_t, Dim>& block) {
    BlockPosition<Dim> at;
    for (int a = 0; a < Dim; ++a) at[static_cast<std::size_t>(a)] = block[a];
    return Morton<Dim>::encode(at);
}

}  // namespace

template <int Dim>
SurfacePlan<Dim>::SurfacePlan(double cell, int of_stencil, bool pressures)
    : h(cell),
      origin(of_stencil),
      finds_(std::make_unique<SurfaceFinds<Dim>>(pressures)),
      geometry_(static_cast<std::size_t>(omp_get_max_threads()), SurfaceGeometry<Dim>(*finds_)) {}

template <int Dim>
void SurfacePlan<Dim>::make(const EpochTables<Dim>& tables, const ContactField<Dim>& of, bool moves) {
    field_ = of;
    constexpr std::size_t kept = 4, always = 4096;  // times those of an epoch, and blocks
    if (moves || block_count_ > kept * blocks.size() + always) forget();
    find_blocks(tables);
    list_blocks(tables);
    list_nodes(tables);
    if (moves) ahead_.clear();
}

template <int Dim>
void SurfacePlan<Dim>::forget() {
    ++generation;
    finds_->forget();
    for (SurfaceGeometry<Dim>& of_thread : geometry_) of_thread.forget();
    found_.clear(), found_nodes_.clear(), near_.clear(), ahead_.clear();
    former_.forget(), former_nodes_.forget();
    block_count_ = 0;
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

/// Own blocks that were not here before.
template <int Dim>
void SurfacePlan<Dim>::find_blocks(const EpochTables<Dim>& tables) {
    std::vector<NewBlock> added;
    own_.clear(), former_.begin();
    for (std::size_t b = 0; b < tables.own.size(); ++b) {
        std::unique_ptr<SurfaceBlock<Dim>>* found = former_.find(tables.own[b]);
        if (!found) {
            const auto [at, is_new] = found_.try_emplace(tables.own[b]);
            found = &at->second;
            if (is_new) added.push_back({found, tables.position[b], false});
        }
        former_.tell(tables.own[b], found);
        own_.push_back(found);
    }
    former_.end();
#pragma omp parallel for schedule(static) if (added.size() > 64)
    for (NewBlock& block : added) block.is_near = is_near(block.place);
    std::erase_if(added, [](const NewBlock& block) { return !block.is_near; });
    make_blocks(added);
}

template <int Dim>
void SurfacePlan<Dim>::make_blocks(const std::vector<NewBlock>& added) {
    const int threads = static_cast<int>(geometry_.size());
#pragma omp parallel for schedule(dynamic) num_threads(threads) if (added.size() > 1)
    for (const NewBlock& block : added) {
        SurfaceGeometry<Dim>& geometry = geometry_[static_cast<std::size_t>(omp_get_thread_num())];
        *block.found =
            std::make_unique<SurfaceBlock<Dim>>(make_surface_block(first_of(block.place), field_, h, geometry));
    }
}

/// Flows come to the neighbours of where they are along a surface, but for those that are below it.
template <int Dim>
void SurfacePlan<Dim>::list_ahead(const Place& block) {
    for (int code = 0; code < power<Dim>(3); ++code) {
        Place place = block;
        for (int a = 0, rest = code; a < Dim; ++a, rest /= 3) place[a] += rest % 3 - 1;
        ahead_.push_back(place);
    }
}

template <int Dim>
bool SurfacePlan<Dim>::is_below(const Place& block) const {
    const Place first = first_of(block);
    for (int k = 0; k < field_.count; ++k) {
        const Structure<Dim>& s = field_.structure[k];
        const Surface<Dim> at = surface(s, field_.corners, node_place(field_, s, &first[0], 1.5));
        double reach = 0.5;
        for (int a = 0; a < Dim; ++a) reach += 2 * std::fabs(at.normal[a]);
        if (at.distance < -reach * h) return true;
    }
    return false;
}

template <int Dim>
bool SurfacePlan<Dim>::prefetch() {
    std::vector<NewBlock> added;
    while (!ahead_.empty() && added.size() < geometry_.size()) {
        const Place place = ahead_.back();
        ahead_.pop_back();
        const auto [at, is_new] = found_.try_emplace(key_of(place));
        if (!is_new || !is_near(place)) continue;
        if (is_below(place))
            found_.erase(at);
        else
            added.push_back({&at->second, place, true});
    }
    make_blocks(added);
    find_nodes_around(added);
    return !added.empty();
}

/// All nodes of the node blocks that these blocks' tiles have nodes of.
template <int Dim>
void SurfacePlan<Dim>::find_nodes_around(const std::vector<NewBlock>& added) {
    const int threads = static_cast<int>(geometry_.size());
#pragma omp parallel for schedule(dynamic) num_threads(threads) if (added.size() > 1)
    for (const NewBlock& block : added)
        for (int n = 0; n < power<Dim>(8); ++n) {
            Place node = block.place;
            for (int a = 0, rest = n; a < Dim; ++a, rest /= 8) node[a] = 4 * node[a] - origin + rest % 8;
            geometry_[static_cast<std::size_t>(omp_get_thread_num())].node(node);
        }
}

template <int Dim>
void SurfacePlan<Dim>::find_nodes(const std::vector<NewNodes>& added) {
    const int threads = static_cast<int>(geometry_.size());
#pragma omp parallel for schedule(dynamic) num_threads(threads) if (added.size() > 1)
    for (const NewNodes& block : added)
        for (int n = 0; n < cells; ++n) {
            Place node = block.place;
            for (int a = 0; a < Dim; ++a) node[a] = 4 * node[a] - origin + cell_coordinate<Dim>(n, a);
            const SurfaceNode<Dim>& found = geometry_[static_cast<std::size_t>(omp_get_thread_num())].node(node);
            block.found->node[n] = {found.distance, found.capacity};
        }
}

template <int Dim>
void SurfacePlan<Dim>::list_blocks(const EpochTables<Dim>& tables) {
    const std::size_t own = tables.own.size();
    ghosts = tables.ghost.size();
    blocks.clear(), block_at.clear();
    bed_of.assign(own + ghosts, -1);
    for (std::size_t b = 0; b < own; ++b) {
        SurfaceBlock<Dim>* found = own_[b]->get();
        if (!found) continue;
        if (found->number == SurfaceBlock<Dim>::unused) {
            found->number = block_count_++;
            if (!found->elements.empty()) list_ahead(tables.position[b]);
        }
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
    std::vector<NewNodes> added;
    former_nodes_.begin();
    for (std::size_t c = 0; c < near_of.size(); ++c)
        for (int d = 0; d < Block<Dim>::corners; ++d) {
            const std::int32_t source = tables.source[c * Block<Dim>::corners + static_cast<std::size_t>(d)];
            if (source < 0 || bed_of[static_cast<std::size_t>(source)] < 0) continue;
            near_of[c] = static_cast<std::int32_t>(near_nodes.size());
            near_nodes.push_back(static_cast<std::int32_t>(c));
            SurfaceNodes<Dim>* found = former_nodes_.find(tables.node_key[c]);
            if (!found) {
                std::unique_ptr<SurfaceNodes<Dim>>& kept = found_nodes_[tables.node_key[c]];
                if (!kept) {
                    kept = std::make_unique<SurfaceNodes<Dim>>();
                    kept->number = found_nodes_.size() - 1;
                    added.push_back({kept.get(), tables.node_position[c]});
                }
                found = kept.get();
            }
            former_nodes_.tell(tables.node_key[c], found);
            nodes_at.push_back(found);
            node_at.push_back(found->node);
            break;
        }
    former_nodes_.end();
    find_nodes(added);
}

template class SurfacePlan<2>;
template class SurfacePlan<3>;

}  // namespace moraine
