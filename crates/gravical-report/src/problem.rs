//! What figures are refused for, each with its sentence.

gravical::errors! {
    "no-folder" usage:
        NoFolder => "figures go into a folder, which this is not" => "name another file for the report";
    "exists" usage:
        EarlierFigures => "this folder holds the figures of an earlier run"
            => "name another file for the report, or replace all of them";
        ForeignFile => "this file has the name of a figure, and is none of this program"
            => "name another file for the report, or move this one";
}
