#include "balance/weight.hpp"

#include "core/error.hpp"

namespace moraine {

BlockWeight::BlockWeight(const BalanceSpec& spec, const CostModel& model) : model_(model) {
    if (spec.weight == "cost")
        kind_ = Kind::cost;
    else if (spec.weight == "time")
        kind_ = Kind::time;
    else if (spec.weight != "particles")
        throw InputError("balance.weight = \"" + spec.weight + "\" (no such weight). Use particles, cost or time?");
}

}  // namespace moraine
