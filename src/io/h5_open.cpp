#include "io/h5_open.hpp"

#include <fmt/format.h>

#include <optional>

#include "io/input_error.hpp"

namespace moraine {
namespace {

std::string elsewhere(const std::string& path) {
    return fmt::format("{} lies in another file, and none is followed", path);
}

/// HDF5 asks before it follows a link into another file.
herr_t refuse_link(const char*, const char*, const char*, const char*, unsigned*, hid_t, void* led_away) {
    *static_cast<bool*>(led_away) = true;
    return -1;
}

template <class Open>
H5Id opened(hid_t list_class, H5Id::Close close, const std::string& path, const std::string& what, const Open& open) {
    bool led_away = false;
    const H5Id list(H5Pcreate(list_class), H5Pclose, what);
    h5_check(H5Pset_elink_cb(list, refuse_link, &led_away), what);
    const hid_t id = open(list);
    if (id < 0 && led_away) throw H5Failure(elsewhere(path));
    return {id, close, what};
}

/// Values in files of their own, or of other datasets.
bool is_elsewhere(hid_t set) {
    const H5Id list(H5Dget_create_plist(set), H5Pclose, "a dataset is damaged");
    return H5Pget_external_count(list) != 0 || H5Pget_layout(list) == H5D_VIRTUAL;
}

/// The first object that leads away from the file.
herr_t check_link(hid_t at, const char* name, const H5L_info_t* info, void* found) {
    auto& away = *static_cast<std::optional<std::string>*>(found);
    if (info->type == H5L_TYPE_SOFT) return 0;  // to a place of this file
    if (info->type != H5L_TYPE_HARD) return away = name, 1;
    const H5Id object(H5Oopen(at, name, H5P_DEFAULT), H5Oclose, "it is damaged");
    return H5Iget_type(object) == H5I_DATASET && is_elsewhere(object) ? (away = name, 1) : 0;
}

}  // namespace

H5Id open_group(hid_t at, const std::string& path, const std::string& what) {
    return opened(H5P_GROUP_ACCESS, H5Gclose, path, what, [&](hid_t list) { return H5Gopen2(at, path.c_str(), list); });
}

H5Id open_dataset(hid_t at, const std::string& path, const std::string& what) {
    H5Id set =
        opened(H5P_DATASET_ACCESS, H5Dclose, path, what, [&](hid_t list) { return H5Dopen2(at, path.c_str(), list); });
    if (is_elsewhere(set)) throw H5Failure(elsewhere(path));
    return set;
}

void check_hdf5_links(const std::string& path) {
    const H5Quiet quiet;
    if (H5Fis_hdf5(path.c_str()) <= 0) return;
    std::optional<std::string> away;
    try {
        const H5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "it is truncated or damaged");
        h5_check(H5Lvisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, check_link, &away), "it is truncated or damaged");
    } catch (const H5Failure& failure) {
        refuse(path, "the file cannot be read", failure.what(), "Is the copy complete?");
    }
    if (away) refuse(path, "the file leads into others", elsewhere(*away), "Make one file of it, by nccopy?");
}

}  // namespace moraine
