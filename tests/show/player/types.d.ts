// What Python hands to the player (simcore/show/run_data.py and live_view.py), for `tsc --checkJs`.

/** Where an array of a block begins [bytes], its rows and its columns. */
type Place = [offset: number, rows: number, columns: number];
type Point = [x: number, y: number, z: number];
type Quaternion = [x: number, y: number, z: number, w: number];
/** A text, or a time [s] and a text that goes there. */
type Cell = string | [time: number, text: string];

/** From when on [s] something was so; null: from then on it was not. */
interface Changes<T> { times: number[]; values: T[] }
interface ColumnGroup { width: number; times?: Place; rows?: Place }
interface SolidData { name: string; color: string; opacity: number; scale: number; vertices: Place; faces: Place }
interface RobotData {
  label: string; name: string; alliance: string; frame: string; open: boolean; size: [number, number]; heights: [number, number]; model: number; parts: number; ink: string; bumper: string;
  own_ink: string; is_run: boolean; intakes: [number, number][][];
}
interface KindData {
  name: string; count: number; round: boolean; radius: number; size: Point; color: string; air: string; edge: string; hole: number | null; solids: SolidData[];
}
interface CurveData {
  label: string; color: string; stepped: boolean; key?: string; low?: number; scale?: number; data?: Place;
}
interface ChartData {
  title: string; unit: string; limit: number | null; limit_label: string; from_zero: boolean; group: string; curves: CurveData[];
}
/** Places where pieces stay, which are counted together; `middle` is that of all of them [m]. */
interface LevelData {
  name: string; alliance: string; label: string; places: string[]; count: number; single: boolean; middle: [number, number] | null;
}
interface TableData { title: string; head: string[]; rows: Cell[][]; open: boolean; wide: boolean }
interface ShotData { time: number; end: number; robot: number; result: "hit" | "miss" | "pass" | "flying"; piece: number }

interface Meta {
  title: string; notes: string[]; failure: string; live: boolean; start: number; end: number;
  groups: Record<string, ColumnGroup>;
  field: {
    size: [number, number]; solids: SolidData[]; outlines: [name: string, side: string, corners: [number, number][]][]; stations: [number, number][];
    tags: [id: number, x: number, y: number, z: number, qw: number, qx: number, qy: number, qz: number][]; tag_size: number;
  };
  models: { body: SolidData[]; parts: SolidData[][] }[];
  robots: RobotData[]; kinds: KindData[]; looks: { name: string; box: boolean; color: string; edge: string }[];
  facts: [string, string][]; verdict: string; board: ({ label: string } & Changes<string | null>)[]; lamps: Record<string, Changes<string>>;
  phases: [time: number, words: string, left: number][]; events: [time: number, kind: string, text: string][];
  tables: TableData[]; charts: ChartData[]; shots: ShotData[]; taken: [time: number, x: number, y: number][]; levels: LevelData[]; cells: Record<string, Changes<number>>;
  // of a live run
  seed?: number; run?: number; spawn?: string[]; people?: [name: string, summary: string][]; view?: string; camera?: string;
  drive?: { robots: number[]; at_once?: boolean; free?: boolean; keys?: string[]; actions?: string[]; help?: string };
}

// What a report lists (simcore/show/report.py), and what charts.js draws.
interface SeriesSpec {
  name: string; x: number[]; y: (number | null)[]; low?: (number | null)[]; high?: (number | null)[];
  kind?: "line" | "dots" | "bars" | "steps"; color?: string;
}
interface DrawingSpec { title?: string; xLabel?: string; yLabel?: string; height?: number }
interface ChartSpec extends DrawingSpec {
  series: SeriesSpec[]; marks?: { x: number; label?: string }[]; levels?: { y: number; label?: string }[]; xNames?: string[] | null;
  xRange?: [number, number] | null; yRange?: [number, number]; fromZero?: boolean; cursor?: number | null; onPick?: (x: number) => void;
}
interface RobotSpec extends DrawingSpec {
  bumpers: [length: number, width: number];
  solids: { name: string; color: string; opacity: number; points: Point[]; faces: Point[] }[];
}
type ReportBlock = { kind: string } & Record<string, any>;

/** A robot or a part between two frames. */
interface Pose { place: Point; quat: Quaternion; belief?: Point | null; active?: boolean }

declare const THREE: any;
interface Window { simcore: any }
