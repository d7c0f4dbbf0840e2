#pragma once
// GDAL's C functions, of a library that is loaded when the first of them is wanted. Not linked: a start of the program
// would pay for the hundred libraries that GDAL stands on. The C interface is the one that GDAL keeps stable.

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <memory>
#include <string>

// clang-format off
#define MORAINE_GDAL_FUNCTIONS(X)                                                                                  \
    X(GDALAllRegister) X(GDALClose) X(GDALCreate) X(GDALDatasetCreateLayer) X(GDALDatasetGetLayer)                 \
    X(GDALDatasetGetLayerCount) X(GDALGetDataTypeName) X(GDALGetDriverByName) X(GDALGetGeoTransform)               \
    X(GDALGetRasterBand) X(GDALGetRasterCount) X(GDALGetRasterDataType) X(GDALGetRasterNoDataValue)                \
    X(GDALGetRasterOffset) X(GDALGetRasterScale) X(GDALGetRasterUnitType) X(GDALGetRasterXSize)                    \
    X(GDALGetRasterYSize) X(GDALGetSpatialRef) X(GDALOpenEx) X(GDALRasterIOEx) X(GDALSetDescription)               \
    X(GDALSetGeoTransform) X(GDALSetMetadataItem) X(OGR_F_SetFieldString) X(GDALSetRasterNoDataValue) X(GDALSetRasterUnitType) X(GDALSetSpatialRef)               \
    X(CPLErrorReset) X(CPLGetLastErrorMsg) X(CPLPushErrorHandler) X(CPLQuietErrorHandler) X(CPLSetConfigOption)    \
    X(CSLDestroy) X(CSLSetNameValue) X(VSIFree) X(VSIGetMemFileBuffer) X(VSIUnlink) X(OSRDestroySpatialReference)  \
    X(OSRExportToWktEx) X(OSRGetAuthorityCode) X(OSRGetAuthorityName) X(OSRGetLinearUnits) X(OSRGetName)           \
    X(OSRIsGeographic) X(OSRIsProjected) X(OSRIsSame) X(OSRNewSpatialReference) X(OSRSetAxisMappingStrategy)       \
    X(OCTDestroyCoordinateTransformation) X(OCTNewCoordinateTransformation) X(OCTTransform) \
    X(OGR_F_Create) X(OGR_F_Destroy) X(OGR_F_GetFieldAsDouble) X(OGR_F_GetFieldAsString) X(OGR_F_GetFieldIndex)    \
    X(OGR_F_GetGeometryRef) X(OGR_F_IsFieldSetAndNotNull) X(OGR_F_SetFieldDouble) X(OGR_F_SetGeometryDirectly)     \
    X(OGR_Fld_Create) X(OGR_Fld_Destroy) X(OGR_GT_Flatten) X(OGR_G_AddGeometryDirectly) X(OGR_G_AddPoint_2D)       \
    X(OGR_G_CreateGeometry) X(OGR_G_GetGeometryCount) X(OGR_G_GetGeometryRef) X(OGR_G_GetGeometryType)             \
    X(OGR_G_GetPointCount) X(OGR_G_GetX) X(OGR_G_GetY) X(OGR_L_CreateFeature) X(OGR_L_CreateField)                 \
    X(OGR_L_GetLayerDefn) X(OGR_L_GetNextFeature) X(OGR_L_GetSpatialRef) X(OGR_L_ResetReading)                     \
    X(GDALDeregisterDriver) X(GDALDestroyDriver) X(GDALGetDriver) X(GDALGetDriverCount) X(GDALGetDriverShortName) X(GDALGetMaskBand)    \
    X(GDALGetMaskFlags) X(GDALGetMetadataItem) X(OGR_F_GetFieldDefnRef) X(OGR_Fld_GetType) X(OSRCloneGeogCS)       \
    X(OSRGetInvFlattening) X(OSRGetSemiMajor) X(OSRSetFromUserInput) X(OSRSetPROJEnableNetwork)
// clang-format on

namespace moraine {

struct GdalLibrary {
#define MORAINE_GDAL_MEMBER(name) decltype(&::name) name = nullptr;
    MORAINE_GDAL_FUNCTIONS(MORAINE_GDAL_MEMBER)
#undef MORAINE_GDAL_MEMBER
};

/// Loads it at the first call. Throws MachineError where it is not there.
const GdalLibrary& gdal();

/// What GDAL said last, in one line.
std::string gdal_message();

struct CloseDataset {
    void operator()(void* d) const { gdal().GDALClose(d); }
};
using GdalDataset = std::unique_ptr<void, CloseDataset>;

struct DestroySystem {
    void operator()(OGRSpatialReferenceH s) const { gdal().OSRDestroySpatialReference(s); }
};
using GdalSystem = std::unique_ptr<std::remove_pointer_t<OGRSpatialReferenceH>, DestroySystem>;

/// x east, y north, of WKT or a code of EPSG. None where the text is empty or says no system.
GdalSystem system_of(const std::string& text);
std::string wkt_of(OGRSpatialReferenceH system);
/// "WGS 84 (EPSG:4326)"
std::string name_of(OGRSpatialReferenceH system);

struct DestroyTransform {
    void operator()(OGRCoordinateTransformationH t) const { gdal().OCTDestroyCoordinateTransformation(t); }
};
using GdalTransform = std::unique_ptr<std::remove_pointer_t<OGRCoordinateTransformationH>, DestroyTransform>;

/// Refuses axes and units that scenes do not have: degrees, feet, depths that count down. Throws InputError.
void check_system(OGRSpatialReferenceH system, const std::string& path);

/// Refuses a file that would have GDAL open what does not lie beside it, or lacks bytes that it speaks of.
void check_source(const std::string& path);

/// Opens a file that stood check_source().
GdalDataset open_gis_file(const std::string& path, const std::string& kind, const std::string& key, unsigned flags);

/// What a writer left in GDAL's memory under this name.
std::string bytes_in_memory(const std::string& name);

}  // namespace moraine
