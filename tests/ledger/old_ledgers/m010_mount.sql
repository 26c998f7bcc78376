BEGIN TRANSACTION;
CREATE TABLE active_versions (
	rocket TEXT NOT NULL, 
	number INTEGER NOT NULL, checksum BIGINT, 
	PRIMARY KEY (rocket), 
	FOREIGN KEY(rocket, number) REFERENCES versions (rocket, number)
);
INSERT INTO "active_versions" VALUES('Astra',1,443654953);
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('m010_mount');
CREATE TABLE configurations (
	rocket TEXT NOT NULL, 
	config TEXT NOT NULL, 
	dry_mass DOUBLE, 
	diameter DOUBLE, 
	length DOUBLE, 
	cd DOUBLE, 
	source TEXT NOT NULL, checksum BIGINT, cg DOUBLE, cp DOUBLE, weighed_mass DOUBLE, measured_diameter DOUBLE, dry_cg DOUBLE, mount_end DOUBLE, 
	PRIMARY KEY (rocket, config)
);
INSERT INTO "configurations" VALUES('Skylark','A',0.4,0.066,0.8,0.52,'skylark.ork',3616401166,NULL,NULL,NULL,NULL,NULL,NULL);
CREATE TABLE drafts (
	name TEXT NOT NULL, 
	content JSON NOT NULL, checksum BIGINT, 
	PRIMARY KEY (name)
);
CREATE TABLE flights (
	entry INTEGER NOT NULL, 
	rocket TEXT NOT NULL, 
	flight_id TEXT NOT NULL, 
	config TEXT NOT NULL, 
	motor TEXT NOT NULL, 
	date_time TEXT, 
	site TEXT NOT NULL, 
	notes TEXT NOT NULL, 
	log TEXT NOT NULL, 
	log_digest TEXT, 
	source TEXT NOT NULL, 
	dry_mass DOUBLE, 
	diameter DOUBLE, 
	delay DOUBLE, 
	site_elevation DOUBLE, 
	temperature DOUBLE, 
	pressure DOUBLE, 
	humidity DOUBLE, 
	wind DOUBLE, 
	rail_length DOUBLE, 
	rail_angle DOUBLE, 
	apogee DOUBLE, 
	top_speed DOUBLE, 
	burn_time DOUBLE, 
	peak_accel DOUBLE, 
	avg_accel DOUBLE, 
	coast_to_apogee DOUBLE, 
	apogee_to_eject DOUBLE, 
	eject_altitude DOUBLE, 
	descent_speed DOUBLE, 
	duration DOUBLE, 
	extra JSON NOT NULL, 
	entered JSON, checksum BIGINT, readout_sd JSON, readout_source JSON, coast_drag DOUBLE, burn_impulse DOUBLE, 
	PRIMARY KEY (entry), 
	UNIQUE (rocket, flight_id), 
	FOREIGN KEY(log_digest) REFERENCES logs (digest)
);
INSERT INTO "flights" VALUES(1,'Astra','1','A','F24-4W','2024-05-04T10:30:00','','','','5775e775a009a883570f8738b2efba72ebd889bebd792398088abf4b78a55133','table.csv',0.322,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,281.3,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'{"Weather": "grey"}',NULL,991599284,NULL,NULL,NULL,NULL);
INSERT INTO "flights" VALUES(2,'Astra','2','A','F24-4W','2024-05-04T10:30:00','','','',NULL,'',0.322,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,200.0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'{}','{"flight_id": "2", "rocket": "Astra", "config": "A", "motor": "F24-4W", "date_time": "2024-05-04T10:30:00", "site": "", "tags": [], "notes": "", "log": "", "dry_mass": 0.322, "diameter": null, "delay": null, "site_elevation": null, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 200.0, "top_speed": null, "burn_time": null, "peak_accel": null, "avg_accel": null, "coast_to_apogee": null, "apogee_to_eject": null, "eject_altitude": null, "descent_speed": null, "duration": null, "extra": {}}',3230378654,NULL,NULL,NULL,NULL);
CREATE TABLE journal (
	number INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	command TEXT NOT NULL, 
	what TEXT NOT NULL, 
	target INTEGER, 
	images JSON, checksum BIGINT, images_checksum BIGINT, 
	PRIMARY KEY (number), 
	FOREIGN KEY(target) REFERENCES journal (number)
);
INSERT INTO "journal" VALUES(1,'2026-11-21T05:12:08+00:00','import','1 from table.csv',NULL,'[["flights", null, {"flight_id": "1", "rocket": "Astra", "config": "A", "motor": "F24-4W", "date_time": "2024-05-04T10:30:00", "site": "", "notes": "", "log": "", "dry_mass": 0.322, "diameter": null, "delay": null, "site_elevation": null, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 281.3, "top_speed": null, "burn_time": null, "peak_accel": null, "avg_accel": null, "coast_to_apogee": null, "apogee_to_eject": null, "eject_altitude": null, "descent_speed": null, "duration": null, "extra": {"Weather": "grey"}, "entry": 1, "log_digest": "5775e775a009a883570f8738b2efba72ebd889bebd792398088abf4b78a55133", "source": "table.csv"}]]',3707536718,1929041515);
INSERT INTO "journal" VALUES(2,'2026-11-21T05:12:08+00:00','import','2',NULL,'[["flights", null, {"flight_id": "2", "rocket": "Astra", "config": "A", "motor": "F24-4W", "date_time": "2024-05-04T10:30:00", "site": "", "notes": "", "log": "", "dry_mass": 0.322, "diameter": null, "delay": null, "site_elevation": null, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 200.0, "top_speed": null, "burn_time": null, "peak_accel": null, "avg_accel": null, "coast_to_apogee": null, "apogee_to_eject": null, "eject_altitude": null, "descent_speed": null, "duration": null, "extra": {}, "entry": 2, "log_digest": null, "source": ""}]]',998625222,3034514158);
INSERT INTO "journal" VALUES(3,'2026-11-21T05:12:08+00:00','tag','2 weak_launch',NULL,'[["flights", {"entry": 2, "entered": null}, {"entry": 2, "entered": {"flight_id": "2", "rocket": "Astra", "config": "A", "motor": "F24-4W", "date_time": "2024-05-04T10:30:00", "site": "", "tags": [], "notes": "", "log": "", "dry_mass": 0.322, "diameter": null, "delay": null, "site_elevation": null, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 200.0, "top_speed": null, "burn_time": null, "peak_accel": null, "avg_accel": null, "coast_to_apogee": null, "apogee_to_eject": null, "eject_altitude": null, "descent_speed": null, "duration": null, "extra": {}}}], ["tags", null, {"entry": 2, "position": 0, "tag": "weak_launch"}]]',2832126733,1024158525);
INSERT INTO "journal" VALUES(4,'2026-11-21T05:12:08+00:00','model','version 1 of Astra, in use',NULL,'[["versions", null, {"rocket": "Astra", "number": 1, "at": "2026-11-21T05:12:08+00:00", "payload": {"effect": "wind"}}], ["active_versions", null, {"rocket": "Astra", "number": 1}]]',3528959097,1018152583);
INSERT INTO "journal" VALUES(5,'2026-11-21T20:27:56+00:00','ork','Skylark A from skylark.ork',NULL,'[["configurations", null, {"rocket": "Skylark", "config": "A", "dry_mass": 0.4, "diameter": 0.066, "length": 0.8, "cd": 0.52, "source": "skylark.ork"}]]',3482426517,2880624538);
CREATE TABLE logs (
	digest TEXT NOT NULL, 
	size INTEGER NOT NULL, 
	content BLOB NOT NULL, 
	PRIMARY KEY (digest)
);
INSERT INTO "logs" VALUES('5775e775a009a883570f8738b2efba72ebd889bebd792398088abf4b78a55133',5,X'789C4B54C8C94F070004F301C4');
CREATE TABLE predictions (
	number INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	rocket TEXT NOT NULL, 
	flight_id TEXT NOT NULL, 
	digest TEXT NOT NULL, 
	payload JSON NOT NULL, checksum BIGINT, 
	PRIMARY KEY (number)
);
INSERT INTO "predictions" VALUES(1,'2026-11-21T05:12:08+00:00','Astra','','d1','{"p50": 1.0}',2708250983);
CREATE TABLE tags (
	entry INTEGER NOT NULL, 
	position INTEGER NOT NULL, 
	tag TEXT NOT NULL, 
	PRIMARY KEY (entry, position), 
	FOREIGN KEY(entry) REFERENCES flights (entry)
);
INSERT INTO "tags" VALUES(2,0,'weak_launch');
CREATE TABLE versions (
	rocket TEXT NOT NULL, 
	number INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	payload JSON NOT NULL, checksum BIGINT, 
	PRIMARY KEY (rocket, number)
);
INSERT INTO "versions" VALUES('Astra',1,'2026-11-21T05:12:08+00:00','{"effect": "wind"}',51630653);
CREATE INDEX flights_by_id ON flights (flight_id);
CREATE INDEX flights_by_date ON flights (date_time, entry);
CREATE INDEX flights_edited ON flights (entry) WHERE entered IS NOT NULL;
CREATE INDEX tags_by_tag ON tags (tag);
CREATE INDEX predictions_by_flight ON predictions (rocket, flight_id);
COMMIT;
