#include "records/surroundings_file.hpp"

#include <algorithm>

#include "core/structures/rigid_body.hpp"
#include "io/hdf5_image.hpp"
#include "records/structure_mesh.hpp"

namespace moraine {
namespace {

using namespace hdf5;
using List = std::vector<std::int64_t>;

/// All times have the same cells; their points follow each other.
Address put_steps(Region& region, const std::vector<double>& times, std::int64_t points) {
    const auto n = static_cast<std::int64_t>(times.size());
    const List zeros(times.size());
    List first;
    for (std::int64_t k = 0; k < n; ++k) first.push_back(k * points);
    const Address zero = region.put_list(zeros, {n}, 2);
    const Address cells = region.put_list(List(4 * times.size()), {n, 4}, 2);
    return region.put(group({{"Values", region.put_list(times, {n})},
                             {"PartOffsets", zero},
                             {"NumberOfParts", region.put_list(List(times.size(), 1), {n})},
                             {"PointOffsets", region.put_list(first, {n})},
                             {"CellOffsets", cells},
                             {"ConnectivityIdOffsets", cells},
                             {"CellDataOffsets", region.put(group({{"structure", zero}}, {}))}},
                            {integer_attribute("NSteps", std::span(&n, 1), true)}));
}

/// points: those of all times, of as many as the mesh has.
std::string image(const StructureMesh& mesh, bool flat, const std::vector<double>& points,
                  const std::vector<double>* times) {
    const std::int64_t cells = static_cast<std::int64_t>(mesh.structure.size());
    const auto ids = static_cast<std::int64_t>(mesh.connectivity.size());
    Region region(superblock_bytes);
    const Address none = region.put(group({{"NumberOfCells", region.put_list(List{0}, {1})},
                                           {"NumberOfConnectivityIds", region.put_list(List{0}, {1})},
                                           {"Connectivity", region.put(dataset({}, {0}, {}, {}))},
                                           {"Offsets", region.put_list(List{0}, {1})}},
                                          {}, 3));
    const Address full = region.put(group({{"NumberOfCells", region.put_list(List{cells}, {1})},
                                           {"NumberOfConnectivityIds", region.put_list(List{ids}, {1})},
                                           {"Connectivity", region.put_list(mesh.connectivity, {ids})},
                                           {"Offsets", region.put_list(mesh.offsets, {cells + 1})}},
                                          {}));
    const Address data = region.put(group({{"structure", region.put_list(mesh.structure, {cells})}}, {}));
    const std::int64_t version[] = {2, 0};
    Links members{{"NumberOfPoints", region.put_list(List{mesh.count()}, {1})},
                  {"Points", region.put_list(points, {static_cast<std::int64_t>(points.size() / 3), 3})},
                  {"CellData", data},
                  {"Vertices", none},
                  {"Lines", flat ? full : none},
                  {"Polygons", flat ? none : full},
                  {"Strips", none}};
    if (times) members.push_back({"Steps", put_steps(region, *times, mesh.count())});
    const Address top =
        region.put(group(members, {integer_attribute("Version", version, false), text_attribute("Type", "PolyData")}));
    const Address root = region.put(group({{"VTKHDF", top}}, {}));
    const std::vector<std::byte> head = superblock(root, region.end());
    std::string bytes(reinterpret_cast<const char*>(head.data()), head.size());
    bytes.append(reinterpret_cast<const char*>(region.get().data()), region.get().size());
    return bytes;
}

/// About what it turns; nothing of one that does not [m].
Vec<double, 3> turning_centre(const Scene& scene, const StructureSpec& s) {
    if (!turns(s.motion)) return zero_vec<double, 3>();
    if (scene.dimensions == 3) return centre_of_mass<3>(s);
    const Vec<double, 2> flat = centre_of_mass<2>(s);
    return {{flat[0], flat[1], 0}};
}

}  // namespace

bool has_surroundings(const Scene& scene) {
    return !std::all_of(scene.structures.begin(), scene.structures.end(), moves);
}

std::string surroundings_image(const Scene& scene) {
    const StructureMesh mesh = structure_mesh(scene, false);
    return image(mesh, scene.dimensions == 2, mesh.points, nullptr);
}

std::string moving_image(const Scene& scene, const std::vector<double>& times,
                         const std::vector<StructureShift>& shifts) {
    std::vector<Vec<double, 3>> centre;
    for (const StructureSpec& s : scene.structures) centre.push_back(turning_centre(scene, s));
    const StructureMesh mesh = structure_mesh(scene, true);
    std::vector<double> points;
    points.reserve(times.size() * mesh.points.size());
    for (std::size_t t = 0; t < times.size(); ++t)
        for (std::size_t p = 0; p < mesh.of_point.size(); ++p) {
            const std::size_t of = mesh.of_point[p];
            const StructureShift& shift = shifts[t * scene.structures.size() + of];
            Vec<double, 3> x{{mesh.points[3 * p], mesh.points[3 * p + 1], mesh.points[3 * p + 2]}};
            if (turns(scene.structures[of].motion))
                x = matrix_of(shift.turned) * (x - centre[of]) - (-1.0) * centre[of];
            for (std::size_t a = 0; a < 3; ++a) points.push_back(x[static_cast<int>(a)] + shift.way[a]);
        }
    return image(mesh, scene.dimensions == 2, points, &times);
}

}  // namespace moraine
