#pragma once
// The constitutive laws as types, in the order by which a LawInfo (core/material/laws.hpp) knows its struct. What
// kernels include of laws: they know no names and no keys.

#include "core/material/drucker_prager.hpp"
#include "core/material/herschel_bulkley.hpp"
#include "core/material/linear_elastic.hpp"
#include "core/material/modified_cam_clay.hpp"
#include "core/material/mu_i.hpp"
#include "core/material/neo_hookean.hpp"
#include "core/material/over_depth.hpp"
#include "core/material/tresca.hpp"
#include "core/material/von_mises.hpp"

namespace moraine {

template <template <class> class... Law>
struct LawList {};

using Laws =
    LawList<LinearElastic, NeoHookean, VonMises, Tresca, HerschelBulkley, DruckerPrager, MuI, ModifiedCamClay,
            LinearElasticOverDepth, NeoHookeanOverDepth, VonMisesOverDepth, TrescaOverDepth, DruckerPragerOverDepth>;

namespace detail {

template <class Real, int Position, class List>
struct LawAt;
template <class Real, template <class> class First, template <class> class... Rest>
struct LawAt<Real, 0, LawList<First, Rest...>> {
    using Type = First<Real>;
};
template <class Real, int Position, template <class> class First, template <class> class... Rest>
struct LawAt<Real, Position, LawList<First, Rest...>> : LawAt<Real, Position - 1, LawList<Rest...>> {};

}  // namespace detail

/// The law at a position of the list.
template <class Real, int Position>
using LawAt = typename detail::LawAt<Real, Position, Laws>::Type;

}  // namespace moraine
