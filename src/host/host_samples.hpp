#pragma once
// What maps, sections and changing gravity ask of the host's particles (core/data/plan_samples.hpp). Binned state only;
// not collective.

#include "blocks/patch.hpp"
#include "core/data/host.hpp"
#include "engine/engine_query.hpp"

namespace moraine {

template <class Real, int Dim>
void find_samples(Patch<Host, Real, Dim>& patch, LayerQuery& query);
template <class Real, int Dim>
void find_samples(Patch<Host, Real, Dim>& patch, ColumnQuery& query);
template <class Real, int Dim>
void find_samples(Patch<Host, Real, Dim>& patch, LineQuery& query);
template <class Real, int Dim>
void find_samples(Patch<Host, Real, Dim>& patch, GravityQuery<Dim>& query);

}  // namespace moraine
