/**
 * Types of the server's documents. schema.d.ts is generated from its OpenAPI document
 * (npm run types); types that it leaves open are spelt out here. All is SI.
 */

import type { components, paths } from './schema';

export type Schemas = components['schemas'];

export type Axis = 'x' | 'y';
export const AXES: readonly Axis[] = ['x', 'y'];

export type Value = string | number | boolean | null | Value[] | { [key: string]: Value };

/** Dotted path to value, as in `--set`. */
export type Changes = Record<string, Value>;

/** A scenario with all names resolved; read through paths, see `at` in scenario-paths.ts. */
export type Scenario = Schemas['Scenario'];

/** Name, unit, bounds and choices of a field. */
export type FieldEntry = Schemas['FieldEntry'];
export type Choice = Schemas['Choice'];
export type ScenarioFields = Schemas['ScenarioFields'];
export type MetricEntry = Schemas['MetricEntry'];

export type ScenarioEntry = Schemas['ScenarioEntry'];
export type LawEntry = Schemas['LawEntry'];
export type Parts = Schemas['Parts'];
export type Change = Schemas['Change'];
/** Any trajectory: `kind` and its numbers. */
export type Trajectory = { readonly [key: string]: Value };
export type TrajectoryEntry = Schemas['TrajectoryEntry'];

/** Scopes and their channels by name, one text for each scope. */
export type ScopeLayout = Schemas['ScopeLayout'];

/** Named values of controllers, with what they achieved when they were saved. */
export interface GainSet extends Omit<Schemas['GainSet'], 'values'> {
  values: Changes;
}

/** State of the drive link. */
export type DriveStatus = Schemas['DriveStatus'];
export type CommissioningStatus = Schemas['CommissioningStatus'];
export type CommissioningRecord = Schemas['CommissioningRecord'];
export type OneDrive = Schemas['OneDrive'];
export type FaultNow = Schemas['FaultNow'];
export type PastFault = Schemas['PastFault'];

export type SessionInfo = Schemas['SessionInfo'];

/** Margins of the loops. */
export type Loops = Schemas['LoopDocument'];

/** Causes of an error peak, and what mends it. */
export type Why = Schemas['WhyDocument'];

export type JobSummary = Schemas['JobSummary'];
export type JobState = Schemas['JobState'];
export type JobKind = JobSummary['kind'];
/** Kinds of studies whose requests have fields; some are answered at once. */
export type StudyKind = JobKind | 'design' | 'platform' | 'sharing' | 'why';
export type JobReport =
  paths['/api/v1/jobs/{job_id}']['get']['responses']['200']['content']['application/json'];
/** Report of a job of one kind. */
export type ReportOf<K extends JobKind> = Extract<JobReport, { kind: K }>;

/** Sizing in both directions. */
export type DesignDocument = Schemas['DesignDocument'];
export type Reading = Schemas['Reading'];

/** Two designs of a moving platform, bent. */
export type PlatformDocument = Schemas['PlatformDocument'];
export type MapEntry = Schemas['MapEntry'];
export type MapTables = Schemas['MapTables'];
/** A force shared among the phases over a pole pitch. */
export type SharingDocument = Schemas['SharingDocument'];
export type MapFit = Schemas['FitDocument'];
export type FieldPicture = Schemas['FieldPicture'];
/** Plan of an identification. */
export type IdentificationPlan = Schemas['PlanDocument'];
export type Identification = Schemas['IdentificationDocument'];
/** Friction models compared on a run. */
export type FrictionModels = Schemas['FrictionModelsDocument'];
export type Motor = Schemas['Motor'];
export type MotorEntry = Schemas['MotorEntry'];
export type IdentificationPartial = Schemas['PartialIdentification'];
export type AxisIdentification = Schemas['AxisIdentification'];
/** A search for gains, and the map of the cost over them. */
export type Candidate = Schemas['Candidate'];
export type TuneGroup = Schemas['TunedGroup'];
export type TunedAxis = Schemas['TunedAxis'];
export type GainMargins = Schemas['GainMargins'];
export type TuneHistory = Schemas['TuneHistory'];
export type AxisLandscape = Schemas['AxisLandscape'];
/** The loop of one axis over frequency. */
export type LoopResponse = Schemas['ResponseDocument'];
/** The loop with the plant as it was measured. */
export type MeasuredLoop = Schemas['MeasuredResponse'];
export type PlantValue = Schemas['PlantValue'];
/** Gains and filters proposed on a measured response. */
export type ShapedLoop = Schemas['ShapeDocument'];
/** Motions made on a machine, and the one that is proposed next. */
export type SafeTune = Schemas['SafeTuneDocument'];
/** Eqs (39) to (42) of one axis, and the simulation. */
export type LoopAccuracy = Schemas['AccuracyDocument'];

export type AxisMetrics = Schemas['AxisMetrics'];
export type ContourMetrics = Schemas['ContourMetrics'];

/** Of a measurement there is no contour error. */
export interface VariantMetrics extends Partial<Pick<Schemas['VariantResult'], 'contour'>> {
  diverged: { time: number } | null;
  /** What to know of its figures; a session has none. */
  notes?: readonly string[];
  axes: Partial<Record<Axis, Partial<AxisMetrics>>>;
}

/** The part of a result document that a session's metrics share with it. */
export interface Metrics {
  window: Schemas['Window'];
  variants: Record<string, VariantMetrics>;
}

export type ProblemField = Pick<Schemas['ProblemField'], 'loc' | 'message'> &
  Partial<Schemas['ProblemField']>;

export interface Problem extends Omit<Schemas['Problem'], 'type' | 'errors'> {
  errors: ProblemField[];
}

export type ServerMessage =
  | Schemas['Hello']
  | Schemas['SessionMessage']
  | Schemas['Subscribed']
  | Schemas['Named']
  | Schemas['Gap']
  | Schemas['Delay']
  | Schemas['Reset']
  | Schemas['ErrorMessage'];

export type ClientMessage =
  Omit<Schemas['Subscribe'], 'frame_ticks'> | Schemas['Acknowledge'] | Schemas['Person'];

/** The paper's numbers, before and after they are computed. */
export type PaperDocument = Schemas['PaperDocument'];
export type PaperKind = Schemas['PaperKind'];
export type PaperRow = Schemas['PaperRow'];
export type JudgedRow = Schemas['JudgedRow'];
export type PaperFigure = Schemas['PaperFigure'];
export type Erratum = Schemas['Erratum'];
/** A scenario on many plausible plants. */
export type MonteCarlo = Schemas['MonteCarloDocument'];
export type Learning = Schemas['LearnDocument'];
export type LearnLap = Schemas['LearnLap'];
export type LearntForce = Schemas['LearntForce'];

/** Metrics over a grid or a list of values of fields. */
export type SweepResult = Schemas['SweepDocument'];
export type SensitivityResult = Schemas['SensitivityDocument'];

/** A run, as lists show it, and with all that makes it reproducible. */
export type Run = Schemas['Run'];
export type RunDetail = Schemas['RunDetail'];
export type RunEvent = Schemas['Event'];
export type RunHistogram = Schemas['RunHistogram'];
export type RunStorage = Schemas['Storage'];
export type RunDifference = Schemas['Difference'];
/** Two runs, channel by channel, and what is asked for. */
export type Comparison = Schemas['Comparison'];
export type ChannelComparison = Schemas['ChannelComparison'];
export type Place = Schemas['Place'];
/** A run simulated again. */
export type Replay = Schemas['Replay'];
/** Many of them, and one. */
export type Replays = Schemas['Replays'];
export type RunReplay = Schemas['RunReplay'];
/** How a file of a measurement is read. */
export type ImportDocument = Schemas['Import'];
export type ImportedColumn = Schemas['ImportedColumn'];
