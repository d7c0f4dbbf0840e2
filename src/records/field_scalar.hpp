#pragma once
// Which scalar of the laws an output field is: by body, because laws keep one of a name at different places.

#include <algorithm>
#include <string>
#include <vector>

#include "core/material/laws.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

struct FieldScalar {
    std::vector<int> of_body;  ///< -1: its law has none
    int column = -1;           ///< that of all, where none has another scalar there
    bool is_one = true;

    FieldScalar(const Scene& scene, const std::string& field) {
        for (const BodySpec& body : scene.bodies) {
            const LawInfo& law = *find_law(scene.materials[static_cast<std::size_t>(body.material)].law);
            const auto& names = law.history_names;
            const auto at = std::find(names.begin(), names.end(), field);
            of_body.push_back(at == names.end() ? -1 : static_cast<int>(at - names.begin()));
            column = std::max(column, of_body.back());
        }
        for (std::size_t b = 0; b < of_body.size(); ++b) {
            const LawInfo& law = *find_law(scene.materials[static_cast<std::size_t>(scene.bodies[b].material)].law);
            is_one = is_one && (of_body[b] == column || (of_body[b] < 0 && law.history <= column));
        }
    }

    /// Columns that value() reads.
    std::vector<std::string> needs() const {
        std::vector<std::string> names{"body"};
        for (int k = 0; k <= column; ++k) names.push_back("history_" + std::to_string(k));
        return names;
    }

    /// Of the particle in slot s; 0 where its law has none.
    template <class View>
    double value(const View& p, std::uint32_t s) const {
        const int k = of_body[p.body[s]];
        return k < 0 ? 0.0 : static_cast<double>(p.history[k][s]);
    }
};

}  // namespace moraine
