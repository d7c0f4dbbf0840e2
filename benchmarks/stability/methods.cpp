#include <deque>

#include "method_name.hpp"
#include "stability/cases.hpp"

namespace moraine {

const std::vector<Choice>& all_methods() {
    static std::deque<std::string> names;
    static const std::vector<Choice> all = [] {
        using enum StressUpdate;
        std::vector<Choice> methods;
        for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic}) {
            for (Transfer transfer : {Transfer::flip, Transfer::pic, Transfer::apic, Transfer::tpic, Transfer::aflip}) {
                if (shape == Shape::linear && is_affine(transfer)) continue;
                for (StressUpdate update : {usl, usf, musl}) {
                    names.push_back(method_name(shape, transfer, update));
                    methods.push_back({names.back().c_str(), shape, transfer, update});
                }
            }
            for (int order : {2, 3}) {
                names.push_back(method_name(shape, Transfer::fmpm, usl, order));
                methods.push_back({names.back().c_str(), shape, Transfer::fmpm, usl, order});
            }
        }
        return methods;
    }();
    return all;
}

}  // namespace moraine
