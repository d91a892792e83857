"""DICOM files for tests, written by pydicom: series of slices, enhanced multi-frame objects, segmentations.

Every file has a patient's name, identity and birth date, which the program must never show: PATIENT.
"""

import datetime

import numpy
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, generate_uid

PATIENT = ("Quixote", "Alonso", "QX-4711-A", "15470929")
CT, ENHANCED_CT, ENHANCED_MR = "1.2.840.10008.5.1.4.1.1.2", "1.2.840.10008.5.1.4.1.1.2.1", "1.2.840.10008.5.1.4.1.1.4.1"
SEG, SR = "1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.88.11"
AXIAL = [1, 0, 0, 0, 1, 0]


def decimal(value):
    """A number as a DS of at most 16 characters."""
    text = f"{value:.10g}"
    return text if len(text) <= 16 else f"{value:.8g}"


def base(sop_class, series, number=1, description="TEST SERIES", syntax=ExplicitVRLittleEndian):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = sop_class
    meta.MediaStorageSOPInstanceUID = generate_uid()
    meta.TransferSyntaxUID = syntax
    data = Dataset()
    data.file_meta = meta
    data.is_little_endian = syntax != pydicom.uid.ExplicitVRBigEndian
    data.is_implicit_VR = syntax == pydicom.uid.ImplicitVRLittleEndian
    data.SOPClassUID = sop_class
    data.SOPInstanceUID = meta.MediaStorageSOPInstanceUID
    data.PatientName = f"{PATIENT[0]}^{PATIENT[1]}"
    data.PatientID = PATIENT[2]
    data.PatientBirthDate = PATIENT[3]
    data.StudyInstanceUID = "1.2.3.4"
    data.SeriesInstanceUID = series
    data.SeriesNumber = number
    data.SeriesDescription = description
    data.FrameOfReferenceUID = "1.2.3.5"
    data.Modality = "CT"
    data.Manufacturer = "Maker"
    data.ImageType = ["ORIGINAL", "PRIMARY", "AXIAL"]
    data.ContentDate = datetime.date(2020, 1, 2).strftime("%Y%m%d")
    return data


def set_pixels(data, array):
    """array: (rows, columns), (rows, columns, 3) or with frames before them; integers or floats."""
    array = numpy.ascontiguousarray(array)
    color = array.ndim > 2 and array.shape[-1] == 3
    rows, columns = array.shape[-3:-1] if color else array.shape[-2:]
    data.Rows, data.Columns = int(rows), int(columns)
    data.SamplesPerPixel = 3 if color else 1
    data.PhotometricInterpretation = "RGB" if color else "MONOCHROME2"
    if color:
        data.PlanarConfiguration = 0
    data.BitsAllocated = data.BitsStored = array.dtype.itemsize * 8
    data.HighBit = data.BitsStored - 1
    data.PixelRepresentation = 1 if array.dtype.kind == "i" else 0
    order = "<" if data.is_little_endian else ">"
    data.PixelData = array.astype(array.dtype.newbyteorder(order)).tobytes()
    if array.dtype.itemsize == 1 and len(data.PixelData) % 2:
        data.PixelData += b"\0"
    data["PixelData"].VR = "OW" if array.dtype.itemsize > 1 or data.is_implicit_VR else "OB"


def save(data, path):
    data.save_as(path, write_like_original=False)
    return path


def image(array, position, series="1.2.3.100", orientation=AXIAL, spacing=(0.5, 0.75), instance=1, slope=None, intercept=None, **options):
    """A slice; spacing: distance of rows, of columns. Further options are attributes, or those of base()."""
    attributes = {name: options.pop(name) for name in list(options) if name[0].isupper()}
    data = base(CT, series, **options)
    data.InstanceNumber = instance
    if position is not None:
        data.ImagePositionPatient = [decimal(value) for value in position]
        data.ImageOrientationPatient = [decimal(value) for value in orientation]
    data.PixelSpacing = [decimal(value) for value in spacing]
    if slope is not None:
        data.RescaleSlope, data.RescaleIntercept = decimal(slope), decimal(intercept)
    set_pixels(data, array)
    for name, value in attributes.items():
        setattr(data, name, value)
    return data


def write_series(folder, volume, positions, names=None, slopes=None, **options):
    """A file per slice of volume[k]; slopes: (slope, intercept) of each."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for k, position in enumerate(positions):
        slope, intercept = slopes[k] if slopes else (None, None)
        data = image(volume[k], position, instance=k + 1, slope=slope, intercept=intercept, **options)
        paths.append(save(data, folder / (names[k] if names else f"slice_{k:03}.dcm")))
    return paths


def item(**attributes):
    data = Dataset()
    for name, value in attributes.items():
        setattr(data, name, value)
    return data


def frame_groups(position, segment=None, slope=None, temporal=None, orientation=None):
    groups = item(PlanePositionSequence=Sequence([item(ImagePositionPatient=[decimal(value) for value in position])]))
    content = Dataset()
    if temporal is not None:
        content.TemporalPositionIndex = temporal
    groups.FrameContentSequence = Sequence([content])
    if segment is not None:
        groups.SegmentIdentificationSequence = Sequence([item(ReferencedSegmentNumber=segment)])
    if slope is not None:
        groups.PixelValueTransformationSequence = Sequence(
            [item(RescaleSlope=decimal(slope[0]), RescaleIntercept=decimal(slope[1]), RescaleType="US")])
    if orientation is not None:
        groups.PlaneOrientationSequence = Sequence([item(ImageOrientationPatient=orientation)])
    return groups


def shared_groups(spacing, thickness, distance=None, orientation=AXIAL):
    measures = item(PixelSpacing=[decimal(value) for value in spacing], SliceThickness=decimal(thickness))
    if distance is not None:
        measures.SpacingBetweenSlices = decimal(distance)
    return item(PixelMeasuresSequence=Sequence([measures]),
                PlaneOrientationSequence=Sequence([item(ImageOrientationPatient=[decimal(value) for value in orientation])]))


def enhanced(frames, positions, spacing=(0.5, 0.75), slopes=None, temporal=None, sop_class=ENHANCED_CT, orientation=AXIAL, **options):
    data = base(sop_class, "1.2.3.200", **options)
    set_pixels(data, frames)
    data.NumberOfFrames = len(frames)
    data.SharedFunctionalGroupsSequence = Sequence([shared_groups(spacing, 2, orientation=orientation)])
    data.PerFrameFunctionalGroupsSequence = Sequence(
        [frame_groups(position, slope=slopes[i] if slopes else None, temporal=temporal[i] if temporal else None)
         for i, position in enumerate(positions)])
    return data


def dicom_lab(rgb):
    """sRGB from 0 to 255 to RecommendedDisplayCIELabValue, by CIE 15 and IEC 61966-2-1 with white D65."""
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in (c / 255 for c in rgb)]
    to_xyz = numpy.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
                          [0.0193339, 0.1191920, 0.9503041]])
    xyz = to_xyz @ linear / (0.950456, 1, 1.088754)
    f = [v ** (1 / 3) if v > 216 / 24389 else (24389 / 27 * v + 16) / 116 for v in xyz]
    lab = 116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])
    return [round(lab[0] / 100 * 65535), round((lab[1] + 128) / 255 * 65535), round((lab[2] + 128) / 255 * 65535)]


def segmentation(masks, names, colors, kind="BINARY", origin=(0, 0, 0), spacing=(0.5, 0.75), distance=2.0, orientation=AXIAL,
                 numbers=None, keep_empty=False, overlap=None, full=255, **options):
    """masks: of each segment (slices, rows, columns): booleans, or fractions from 0 to 1."""
    data = base(SEG, "1.2.3.300", number=300, description="Segmentation", **options)
    data.Modality = "SEG"
    data.SegmentationType = kind
    normal = numpy.cross(orientation[:3], orientation[3:])
    numbers = numbers or list(range(1, len(masks) + 1))
    frames, groups, segments = [], [], []
    for mask, name, color, number in zip(masks, names, colors, numbers):
        segment = item(SegmentNumber=number, SegmentLabel=name, SegmentAlgorithmType="MANUAL")
        if color is not None:
            segment.RecommendedDisplayCIELabValue = dicom_lab(color)
        segments.append(segment)
        for k, plane in enumerate(mask):
            if plane.any() or keep_empty:
                frames.append(plane)
                groups.append(frame_groups(numpy.array(origin) + k * distance * normal, segment=number))
    frames = numpy.array(frames)
    data.SegmentSequence = Sequence(segments)
    if overlap is not None:
        data.SegmentsOverlap = overlap
    if kind == "BINARY":
        set_pixels(data, frames.astype(numpy.uint8))
        data.BitsAllocated = data.BitsStored = 1
        data.HighBit = 0
        bits = numpy.packbits(frames.astype(numpy.uint8).ravel(), bitorder="little").tobytes()
        data.PixelData = bits + b"\0" * (len(bits) % 2)
    else:
        data.MaximumFractionalValue = full
        set_pixels(data, numpy.rint(frames * full).astype(numpy.uint8))
    data.NumberOfFrames = len(frames)
    data.SharedFunctionalGroupsSequence = Sequence([shared_groups(spacing, distance, distance, orientation)])
    data.PerFrameFunctionalGroupsSequence = Sequence(groups)
    return data


def report():
    """An object without pixels."""
    data = base(SR, "1.2.3.400", number=400, description="Report")
    data.Modality = "SR"
    return data
