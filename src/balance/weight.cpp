#include "balance/weight.hpp"

#include "core/data/error.hpp"

namespace moraine {

BlockWeight::BlockWeight(const BalanceSpec& spec, const CostModel& model, int cells)
    : model_(model), block_((cells * model.c + model.d) / std::max<std::int64_t>(1, model.a)) {
    if (spec.weight == "cost")
        kind_ = Kind::cost;
    else if (spec.weight == "time")
        kind_ = Kind::time;
    else if (spec.weight != "particles")
        throw InputError("balance.weight = \"" + spec.weight + "\" (no such weight). Use particles, cost or time?");
}

}  // namespace moraine
