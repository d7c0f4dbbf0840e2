#pragma once
// Which blocks and nodes of an epoch are near surfaces (Bed::surface), and what these find there. All of it follows
// from places, the same on all ranks, on hosts and on devices.
//
// What a block or a node block finds is kept from epoch to epoch, and is found when it first appears: an epoch's work
// is its lists and what is new, which a rank that waits has found before. Where a structure moves all is forgotten in
// each step; where a flow has gone far, what it left behind. Threads share what is new, and what they find of the
// geometry.

#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "blocks/epoch.hpp"
#include "blocks/surface_block.hpp"
#include "core/structures/surface_space.hpp"

namespace moraine {

/// What the nodes of a node block find.
template <int Dim>
struct SurfaceNodes {
    std::size_t number;  ///< as SurfaceBlock's
    SpaceNode node[Block<Dim>::cells];
};

/// Values of the epoch before, by key; both epochs ascend.
template <class T>
class FormerValues {
  public:
    void begin() { next_ = 0, now_.clear(); }
    /// Of a key of this epoch; null: the one before had none. Keys are asked for in their order, and told after that.
    T* find(Key key) {
        while (next_ < former_.size() && former_[next_].first < key) ++next_;
        return next_ < former_.size() && former_[next_].first == key ? former_[next_].second : nullptr;
    }
    void tell(Key key, T* value) { now_.push_back({key, value}); }
    void end() { std::swap(former_, now_); }
    void forget() { former_.clear(); }

  private:
    std::vector<std::pair<Key, T*>> former_, now_;
    std::size_t next_ = 0;
};

template <int Dim>
class SurfacePlan {
  public:
    static constexpr int width = 3, cells = Block<Dim>::cells, nodes = power<Dim>(3);
    static constexpr int side = SurfaceBlock<Dim>::side, tile_nodes = SurfaceBlock<Dim>::tile_nodes;
    static constexpr int to_middle = SurfaceBlock<Dim>::to_middle;
    using Place = Vec<std::int32_t, Dim>;

    double h;    ///< [m]
    int origin;  ///< of the stencil
    std::size_t ghosts = 0;
    std::vector<std::int32_t> blocks{}, bed_of{};       ///< own; by own and ghost block
    std::vector<std::int32_t> near_nodes{}, near_of{};  ///< node blocks, and their numbers among those
    std::vector<SurfaceBlock<Dim>*> block_at{};         ///< [block]
    std::vector<const SurfaceNodes<Dim>*> nodes_at{};   ///< [near node block]
    std::vector<const SpaceNode*> node_at{};            ///< the same: of their nodes
    std::int64_t generation = 0;                        ///< times that all was forgotten

    /// cell: h [m]; pressures: those of cells are the grid's.
    SurfacePlan(double cell, int of_stencil, bool pressures);
    SurfaceSpace space() const { return {near_of.data(), node_at.data()}; }
    /// For the blocks of an epoch. What has been found so far holds unless a structure moves. Not collective.
    template <class Real>
    void make(const EpochTables<Dim>& tables, const ContactField<Dim>& of, bool moves, const Walls<Real, Dim>& walls,
              const NodeCapacity<Real, Dim>& ends) {
        for (SurfaceGeometry<Dim>& of_thread : geometry_) of_thread.begin(of, walls, ends);
        make(tables, of, moves);
    }
    /// Finds a few of the blocks that a flow may come to, each thread one, and says whether there were any. The field
    /// of make() still holds. Not collective.
    bool prefetch();

  private:
    struct NewBlock {
        std::unique_ptr<SurfaceBlock<Dim>>* found;
        Place place;
        bool is_near;
    };
    struct NewNodes {
        SurfaceNodes<Dim>* found;
        Place place;
    };

    void make(const EpochTables<Dim>& tables, const ContactField<Dim>& of, bool moves);
    void forget();
    void find_blocks(const EpochTables<Dim>& tables);
    void make_blocks(const std::vector<NewBlock>& added);
    void find_nodes_around(const std::vector<NewBlock>& added);
    void list_ahead(const Place& block);
    bool is_below(const Place& block) const;
    void list_blocks(const EpochTables<Dim>& tables);
    void list_nodes(const EpochTables<Dim>& tables);
    void find_nodes(const std::vector<NewNodes>& added);
    bool is_near(const Place& block) const;

    ContactField<Dim> field_{};
    std::unique_ptr<SurfaceFinds<Dim>> finds_;
    std::vector<SurfaceGeometry<Dim>> geometry_;                           ///< by thread
    std::unordered_map<Key, std::unique_ptr<SurfaceBlock<Dim>>> found_{};  ///< own; null: no surface is near
    std::unordered_map<Key, bool> near_{};                                 ///< ghosts
    std::unordered_map<Key, std::unique_ptr<SurfaceNodes<Dim>>> found_nodes_{};
    FormerValues<std::unique_ptr<SurfaceBlock<Dim>>> former_{};
    FormerValues<SurfaceNodes<Dim>> former_nodes_{};
    std::vector<std::unique_ptr<SurfaceBlock<Dim>>*> own_{};  ///< by own block: what is found of it
    std::vector<Place> ahead_{};                              ///< where flows may come to next
    std::size_t block_count_ = 0;                             ///< that epochs have had
};

}  // namespace moraine
