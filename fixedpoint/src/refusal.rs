//! Why something was refused: small enums, each variant with a sentence.

use core::fmt;

/// Implements `Display`, one sentence for each variant, and `Error`.
macro_rules! sentences {
    ($refusal:ty { $($variant:ident: $sentence:literal),+ $(,)? }) => {
        impl fmt::Display for $refusal {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str(match self {
                    $(Self::$variant => $sentence,)+
                })
            }
        }

        impl core::error::Error for $refusal {}
    };
}

/// Why a scan line, or what it shows by one of its thresholds or of one format, was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineRefusal {
    /// `LINE-2`.
    Width,
    /// `THRESH-4`.
    LowContrast,
    /// `REGION-5`.
    TooManyRegions,
    /// `DECODE-2`.
    TooManyLayers,
}

sentences!(LineRefusal {
    Width: "the scan line is not as long as the camera is wide",
    LowContrast: "the scan line's range is below 24 grey levels",
    TooManyRegions: "the scan line has more than 255 regions by one of its thresholds",
    TooManyLayers: "the scan line has more than 8 layers of one format",
});

/// Why a region of interest was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HypothesisRefusal {
    /// `HYPO-12`.
    Repeated,
    /// `HYPO-6`.
    TooFewBars,
    /// `HYPO-7`.
    TooManyBars,
    /// `HYPO-8`.
    CutOff,
    /// `HYPO-9`.
    QuietZone,
    /// `HYPO-11`.
    TooNarrow,
    /// `HOMOG-3`.
    Implausible,
    /// `SAMPLE-5`.
    Guard,
    /// `SAMPLE-6` and `SAMPLE-8`.
    Transition,
    /// `SAMPLE-10`.
    Residual,
}

sentences!(HypothesisRefusal {
    Repeated: "the global threshold decoded a layer of the format there",
    TooFewBars: "it has fewer bars than two guards",
    TooManyBars: "it has more bars than a layer has pairs of stripes",
    CutOff: "it reaches an end of the scan line",
    QuietZone: "the white beside it is too narrow for a quiet zone",
    TooNarrow: "it has less than 1.25 px per stripe",
    Implausible: "its homography is mirrored or too oblique",
    Guard: "a guard stripe does not fall in its region",
    Transition: "its transitions are not those of its stripes",
    Residual: "its transitions do not lie where the format has edges",
});

/// Why a pair of layers, or a detection, was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairRefusal {
    /// `CODE-7`.
    EqualHalves,
    /// `CODE-8`.
    Crc,
}

sentences!(PairRefusal { EqualHalves: "both halves of the code word are equal", Crc: "the check byte is wrong" });

/// Why a fit was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitRefusal {
    /// `FIT-12`.
    TooFewPixels,
    /// `FIT-13`.
    NotConverged,
}

sentences!(FitRefusal {
    TooFewPixels: "its windows have too few pixels for the fit's parameters",
    NotConverged: "the fit did not converge to a barcode",
});

/// Why a candidate did not become a detection (`MERGE-9`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CandidateRefusal {
    /// `TRELLIS-7`.
    Unsettled,
    /// `ACCEPT-10` and `ACCEPT-11`.
    NoFit,
    /// `ACCEPT-2`.
    Disagree,
    /// `ACCEPT-3`.
    Oblique,
    /// `ACCEPT-4` and `ACCEPT-14`.
    Contrast,
    /// `ACCEPT-5`.
    Blur,
    /// `ACCEPT-6` and `ACCEPT-13`.
    Misfit,
    /// `ACCEPT-15`.
    Correlated,
    /// `ACCEPT-16`.
    QuietZone,
    /// `ACCEPT-7`.
    Margin,
    /// `ACCEPT-12`.
    Undetermined,
    /// `MERGE-10`.
    TooMany,
}

sentences!(CandidateRefusal {
    Unsettled: "its half words still change after the third fit",
    NoFit: "no barcode can be fitted to its pixels",
    Disagree: "its layers' homographies are not of one barcode",
    Oblique: "it would be seen at more than 72 degrees",
    Contrast: "one of its layers has too little contrast, half that of the other, or a black below zero",
    Blur: "its blur is above 1 px, or above 0.9 px by the trellis",
    Misfit: "its pixels are not those of the barcode it was read as",
    Correlated: "what it leaves unexplained is no noise",
    QuietZone: "the pixels beside it are no quiet zone",
    Margin: "another code word explains its pixels nearly as well",
    Undetermined: "its fit leaves the camera's heading open",
    TooMany: "the scan lines have given 8 detections before it",
});

/// Why a payload was not encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncodeRefusal {
    /// `CODE-5`.
    TooLarge,
    /// `CODE-6`.
    EqualHalves,
}

sentences!(EncodeRefusal {
    TooLarge: "the payload has more bits than the format",
    EqualHalves: "both halves of the code word would be equal",
});

/// Why a camera's description was refused (`CAM-7`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraRefusal {
    /// The width is outside 32 to 640 px.
    Width,
    /// The focal length is outside half the width to 2048 px.
    FocalLength,
    /// The principal column is outside the scan line.
    PrincipalColumn,
}

sentences!(CameraRefusal {
    Width: "the camera's width is outside 32 to 640 px",
    FocalLength: "the focal length is outside half the width to 2048 px",
    PrincipalColumn: "the principal column is outside the scan line",
});

/// Why a landmark's description was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LandmarkRefusal {
    /// The stripe width is outside 0.5 to 20 mm.
    StripeWidth,
}

sentences!(LandmarkRefusal { StripeWidth: "the stripe width is outside 0.5 to 20 mm" });

/// Why an image was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageRefusal {
    /// `EXPOSE-2`.
    Capture,
}

sentences!(ImageRefusal {
    Capture: "its capture takes no time, takes more than a second, or ends after its processing",
});

/// Why a drive's description was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveRefusal {
    /// The wheels' diameter is outside 5 to 250 mm.
    Diameter,
    /// The axle is outside 20 to 800 mm.
    Axle,
    /// A turn has fewer than 64 steps.
    Steps,
}

sentences!(DriveRefusal {
    Diameter: "the wheels' diameter is outside 5 to 250 mm",
    Axle: "the axle is outside 20 to 800 mm",
    Steps: "a turn of a wheel has fewer than 64 steps",
});

/// Why a grid's description was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpacingRefusal {
    /// A step is 0.
    Step,
    /// The number of headings is outside 1 to 16 (`GRID-3`).
    Headings,
}

sentences!(SpacingRefusal {
    Step: "a step of the grid is 0",
    Headings: "the grid's number of headings is outside 1 to 16",
});

/// Why a payload is no pose on a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridRefusal {
    /// It has more bits than the format.
    TooLarge,
    /// `GRID-6`.
    Heading,
    /// The place is not within the format of lengths.
    Beyond,
}

sentences!(GridRefusal {
    TooLarge: "the payload has more bits than the format",
    Heading: "its code of the heading is not below the grid's number of headings",
    Beyond: "its place is more than 128 m from the world's origin",
});

/// Why a reading or an observation was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Untimely {
    /// `TIME-7` and `TIME-9`.
    Late,
    /// `TIME-8`.
    Duplicate,
    /// `TIME-9`.
    Full,
}

sentences!(Untimely {
    Late: "its time is not after what is settled",
    Duplicate: "another one of its time is in the queue, of the same landmark and image if it is an observation",
    Full: "the queue has no room, and nothing in it can be settled",
});

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_refusal_says_why() {
        assert_eq!(LineRefusal::TooManyLayers.to_string(), "the scan line has more than 8 layers of one format");
        assert_eq!(PairRefusal::Crc.to_string(), "the check byte is wrong");
    }
}
