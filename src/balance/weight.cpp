#include "balance/weight.hpp"

#include "core/error.hpp"

namespace moraine {

BlockWeight::BlockWeight(const BalanceSpec& spec, const CostModel& model)
    : is_cost_(spec.weight == "cost"), model_(model) {
    if (!is_cost_ && spec.weight != "particles")
        throw InputError("balance.weight = \"" + spec.weight + "\" (no such weight). Use particles or cost?");
}

}  // namespace moraine
